/* Lane kernels: single, portable instructions. */
#define HB_LANE_SINGLE
#define HB_LANE_TABLE hb_lane_single_portable
#define HB_LANE_NAME "single portable"
#include "lane/kernels.h"
