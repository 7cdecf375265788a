/* Which kernels run here. */
#include "lane/strip.h"

extern const hb_lane_kernels hb_lane_double_portable, hb_lane_single_portable;
#ifdef HB_LANE_AVX2
extern const hb_lane_kernels hb_lane_double_avx2, hb_lane_single_avx2;
#endif

/* The fastest that the processor has; the bits are the same. */
const hb_lane_kernels *hb_lane_kernels_for(bool single, bool portable) {
#ifdef HB_LANE_AVX2
  if (!portable && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
    return single ? &hb_lane_single_avx2 : &hb_lane_double_avx2;
#else
  (void)portable;
#endif
  return single ? &hb_lane_single_portable : &hb_lane_double_portable;
}
