#include "output/series.h"

#define ROW(name, unit, text)                                                                                \
  { #name, unit, text, offsetof(hb_frame, name), false }
#define VECTOR(name, unit, text)                                                                             \
  {#name "_x", unit, "x component of the " text, offsetof(hb_frame, name), false},                           \
      {#name "_y", unit, "y component of the " text, offsetof(hb_frame, name) + sizeof(double), false}, {    \
#name "_z", unit, "z component of the " text, offsetof(hb_frame, name) + 2 * sizeof(double), false       \
  }

const hb_series hb_series_table[] = {
    ROW(time, "time", "time of the frame"),
    {"step", "1", "steps done", offsetof(hb_frame, step), true},
    ROW(kinetic, "energy", "kinetic energy"),
    ROW(bending, "energy", "bending energy"),
    ROW(twisting, "energy", "twisting energy"),
    ROW(gravity, "energy", "potential energy in constant uniform gravity"),
    ROW(work_loads, "energy", "work of the loads since the start, gravity included"),
    ROW(work_supports, "energy", "work of moving supports since the start"),
    ROW(dissipated, "energy", "energy taken out by damping since the start"),
    ROW(balance, "energy", "energy now - at start - work + dissipated: the error of the scheme"),
    VECTOR(momentum, "mass*length/time", "linear momentum"),
    VECTOR(angular_momentum, "mass*length^2/time", "angular momentum about the origin"),
    ROW(length_error, "1", "largest relative length error of an edge"),
    ROW(worst_length_error, "1", "the same, largest over the run"),
    ROW(stretching, "energy", "stretching energy; 0 where rods are inextensible"),
};
const int hb_series_count = (int)(sizeof hb_series_table / sizeof hb_series_table[0]);
