/* The table of one file's kernels: HB_LANE_TABLE names it, HB_LANE_NAME says what it is. */
#include "lane/general.h"
#include "lane/loads.h"
#ifndef HB_LANE_SINGLE
#include "lane/frames.h"
#endif

extern const hb_lane_kernels HB_LANE_TABLE;
const hb_lane_kernels HB_LANE_TABLE = {
    .name = HB_LANE_NAME,
    .lanes = HB_LANES,
    .single = sizeof(hb_real) == sizeof(float),
    .advance = advance,
    .eliminate = eliminate,
    .close = close_rows,
    .spread = spread,
    .join_spread = join_spread,
    .transport = transport,
    .flex = flex,
    .assemble = assemble,
    .elastic = elastic,
    .join_elastic = join_elastic,
    .carry = carry,
    .look = look,
    .solve_turns = solve_turns,
    .turn = turn_all,
    .drop_turns = drop_turns,
    .general = general,
    .loads = loads,
    .eliminate_rates = eliminate_rates,
    .spread_rates = spread_rates,
    .sum_up = sum_up,
#ifndef HB_LANE_SINGLE
    .carry_directors = carry_directors,
    .panel_twist = panel_twist,
    .director_angle = director_angle,
#endif
};
