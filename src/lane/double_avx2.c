/* Lane kernels: double, avx2 instructions. */
#define HB_LANE_TABLE hb_lane_double_avx2
#define HB_LANE_NAME "double avx2"
#include "lane/kernels.h"
