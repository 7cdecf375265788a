/* Lane kernels: double, portable instructions. */
#define HB_LANE_TABLE hb_lane_double_portable
#define HB_LANE_NAME "double portable"
#include "lane/kernels.h"
