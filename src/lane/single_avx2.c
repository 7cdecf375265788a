/* Lane kernels: single, avx2 instructions. */
#define HB_LANE_SINGLE
#define HB_LANE_TABLE hb_lane_single_avx2
#define HB_LANE_NAME "single avx2"
#include "lane/kernels.h"
