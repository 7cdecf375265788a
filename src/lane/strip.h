/* Strips: rods in lanes, the working layout of a run (docs/theory/10-lanes.md).
 *
 * A strip is a block of rows with one number per lane and row. Its lanes are either different rods (a bundle)
 * or consecutive pieces of one rod; a long rod is a row of strips. Row r of a lane is that lane's vertex r or
 * edge r (which joins its vertices r and r + 1). In pieces the last vertex of a lane is the first one of the
 * next, kept twice with the same bits. Lanes may end early: rows without a real edge are phantoms, whose
 * vertices have no mobility and whose edges neither bend nor pull. */
#ifndef HB_LANE_STRIP_H
#define HB_LANE_STRIP_H

#include <stdbool.h>
#include <stddef.h>

#define HB_LANES_DOUBLE 4
#define HB_LANES_SINGLE 8
#define HB_LANES_MAX 8
#define HB_LAW_NUMBERS 17 /* of hb_uniform_load, the last of them its damping */

/* Arrays of a strip: name, rows beyond the edges' K (a vertex array has K + 1), numbers per row, sentence. */
#define HB_STRIP_FIELDS(F)                                                                                   \
  F(x, 1, 3, "vertex positions")                                                                             \
  F(x_old, 1, 3, "positions at the start of the step")                                                       \
  F(v, 1, 3, "velocities")                                                                                   \
  F(f, 1, 3, "force on the vertices without constraints")                                                    \
  F(lambda, 0, 1, "pull of each edge per its vector, summed over a projection")                              \
  F(lambda_old, 0, 1, "the same at the start of the step, a first guess for schemes that use one")           \
  F(mobility, 1, 1, "1/mass, 0 for a prescribed vertex")                                                     \
  F(half_rest2, 0, 1, "|e-bar|^2/2")                                                                         \
  F(inv_rest, 2, 1, "1/|e-bar|; row 0 belongs to the edge before the first, row K + 1 to the one behind")    \
  F(bend_gain, 1, 1, "8 alpha/l, 0 where nothing bends")                                                     \
  F(inv_pivot, 1, 1, "1/pivot of the elimination; with the two behind it also f_twist")                      \
  F(link, 1, 1, "entry by which the row before needs this row's unknown, sign turned")                       \
  F(right, 1, 1, "right-hand sides, then unknowns")                                                          \
  F(v_old, 1, 3, "velocities at the start of the step")

/* The same where loads act. */
#define HB_STRIP_LOAD_FIELDS(F)                                                                              \
  F(load, 1, 3, "the part of f that comes from loads, whose work is booked")                                 \
  F(mass, 1, 1, "mass; 0 for phantoms, and for them only")                                                   \
  F(weight, 1, 1, "length that belongs to a vertex")

/* The same for pieces only. */
#define HB_STRIP_PIECE_FIELDS(F) F(fill, 0, 1, "entry by which a row needs the unknown in front of its piece")

/* The same where twisting moments differ from vertex to vertex. */
#define HB_STRIP_MOMENT_FIELDS(F) F(moment, 1, 1, "twisting moment at the vertices")

/* The same for strips of general rods only. */
#define HB_STRIP_GENERAL_FIELDS(F)                                                                           \
  F(t, 0, 3, "tangents")                                                                                     \
  F(inv_length, 0, 1, "1/|e|")                                                                               \
  F(m1, 0, 3, "first material directors")                                                                    \
  F(spin, 0, 1, "how far directors turned beyond parallel transport in the last step")                       \
  F(twist, 1, 1, "twist m_i with windings")                                                                  \
  F(kb, 1, 3, "curvature binormals")                                                                         \
  F(stress, 1, 4, "B omega - pull of both sides of a vertex")                                                \
  F(turn_gradient, 0, 1, "dE/dtheta")                                                                        \
  F(inv_l, 1, 1, "1/l_i, 0 where nothing bends")                                                             \
  F(twist_gain, 1, 1, "2 beta_i/l_i")                                                                        \
  F(twist_link, 1, 1, "entry of the Hessian between the edges of a vertex, 0 where one is held")             \
  F(rest_twist, 1, 1, "m-bar_i")                                                                             \
  F(B, 0, 3, "B11, B12, B22")                                                                                \
  F(pull, 1, 4, "B omega-bar of both sides of a vertex")                                                     \
  F(free, 0, 1, "1, or 0 for an edge whose frame is held and for phantoms")

/* What a pass over a strip leaves behind for those who put pieces together. One row of lanes each. */
#define HB_STRIP_RECORDS(F)                                                                                  \
  F(count, 1, "edges of each lane")                                                                          \
  F(active, 1, "1 in lanes whose lengths are still being worked on, else 0")                                 \
  F(worst, 1, "largest length error found")                                                                  \
  F(left, 1, "largest length error that a correction leaves behind")                                         \
  F(full, 1, "1 where all rows had sound pivots, else 0")                                                    \
  F(sep_pivot, 1, "pivot of each lane's last row")                                                           \
  F(sep_diagonal, 1, "its diagonal before the elimination")                                                  \
  F(sep_right, 1, "its right-hand side")                                                                     \
  F(sep_low, 1, "its entry by the unknown in front of the piece")                                            \
  F(sep_up, 1, "entry of the row in front of the piece by it")                                               \
  F(schur_diagonal, 1, "what the piece takes from the diagonal of the row in front of it")                   \
  F(schur_right, 1, "and from its right-hand side")                                                          \
  F(sep, 1, "unknown of each lane's last row")                                                               \
  F(sep_before, 1, "unknown in front of each lane")                                                          \
  F(last_pull, 3, "edge vector along which the last row pulls")                                              \
  F(first_moved, 3, "how vertex 0 moved")                                                                    \
  F(last_moved, 3, "how vertex K - 1 moved")                                                                 \
  F(first_stress, 3, "force on edge 0")                                                                      \
  F(last_stress, 3, "force on edge K - 1")                                                                   \
  F(first_twist, 3, "and per unit of twisting moment, on edge 0")                                            \
  F(last_twist, 3, "on edge K - 1")                                                                          \
  F(lowest_chi, 1, "smallest 1 + t.t'")                                                                      \
  F(rod_moment, 1, "twisting moment of each lane's rod, where it is one for the whole rod")                  \
  F(keep, 1, "part of the last spin that is a good guess for the next (general rods)")                       \
  F(scale, 1, "what the terms of dE/dtheta are made of (general rods)")                                      \
  F(floor, 1, "largest twisting gain (general rods)")                                                        \
  F(finite, 1, "a sum that is finite if all of the strip's numbers are")                                     \
  F(law, HB_LAW_NUMBERS, "uniform load on each lane's rod: the numbers of hb_uniform_load in their order")   \
  F(work, 1, "sum of (load before + load now) . way over the vertices of a lane")                            \
  F(lost, 1, "sum of m |way|^2 over them")

typedef struct hb_strip {
  int lanes;                     /* HB_LANES_DOUBLE or HB_LANES_SINGLE */
  int rows;                      /* K: edges of the longest lane, at least 2 */
  int full_rows;                 /* rows in which every lane has an edge */
  int first_edge;                /* pieces: edge of the rod at row 0 of lane 0 */
  bool single;                   /* floats, not doubles */
  bool pieces;                   /* lanes are pieces of one rod */
  bool twisted;                  /* some rod of it carries a twisting moment */
  bool general;                  /* its rods are anisotropic or curved at rest */
  bool uniform;                  /* twisted: every rod of it has one moment from end to end */
  bool loaded;                   /* loads act on some rod of it */
  bool windy, damped;            /* some lane's rod meets drag, mass damping as a uniform load */
  bool known_t;                  /* t holds the directions of the edges of x_old */
  bool split;                    /* f holds forces on edges, not on vertices yet */
  bool relative;                 /* length errors are judged relative to the rest length */
  const struct hb_strip *before; /* neighbours along the same rod, NULL at its ends */
  const struct hb_strip *after;
  void *f_twist; /* split: 3 per edge, force per unit of twisting moment, until the next elimination */
  int *cuts;     /* twisted: rows where a product of transports ends, ascending; the last is K - 1 */
  int cut_count;
  void *turns; /* 4 per cut: the products as quaternions, real part first */
#define HB_DECLARE(name, extra, numbers, text) void *name;
  HB_STRIP_FIELDS(HB_DECLARE)
  HB_STRIP_PIECE_FIELDS(HB_DECLARE)
  HB_STRIP_MOMENT_FIELDS(HB_DECLARE)
  HB_STRIP_GENERAL_FIELDS(HB_DECLARE)
  HB_STRIP_LOAD_FIELDS(HB_DECLARE)
#undef HB_DECLARE
#define HB_DECLARE(name, numbers, text) void *name;
  HB_STRIP_RECORDS(HB_DECLARE)
#undef HB_DECLARE
} hb_strip;

/* Directors d of HB_LANES_DOUBLE rods, one of each, on edges that were along the unit vectors t. */
typedef struct hb_lane_director {
  _Alignas(64) double e[3 * HB_LANES_DOUBLE]; /* the edge now; then t points along it */
  double t[3 * HB_LANES_DOUBLE], d[3 * HB_LANES_DOUBLE];
} hb_lane_director;

/* The passes of a step over one strip, compiled per precision and instruction set. */
typedef struct hb_lane_kernels {
  const char *name; /* "double avx2" ... */
  int lanes;
  bool single;
  /* v = v_old + kick M^-1 f; x = x_old + drift v; with guess: and the pull of lambda_old along the old edges,
   * with which lambda begins. */
  void (*advance)(hb_strip *strip, double kick, double drift, bool guess);
  /* Assembles and eliminates the rows of the length constraints; along: corrections go along the old edges.
   */
  void (*eliminate)(hb_strip *strip, bool along);
  /* Back substitution and corrections of x; inv_h != 0: of v, too. along: books lambda instead. */
  void (*spread)(hb_strip *strip, bool along, double inv_h);
  /* Unknowns of the last rows of all pieces of a rod; system: 4 per lane. False if a pivot is not sound (with
   * definite: not clearly positive). */
  bool (*close)(hb_strip *strips, int count, bool definite, double *system);
  /* Copies of vertices that strips share, and the length error of the edge between them. */
  void (*join_spread)(hb_strip *strip, bool along);
  /* Products of transports from cut to cut, smallest 1 + t.t'. exact: lengths may be off by more than 5e-9.
   */
  void (*transport)(hb_strip *strip, bool exact);
  /* The same with forces on edges: of bending into f and, per unit of twisting moment, into f_twist; for
   * uniform strips. What needs them first puts them together, at the latest assemble. */
  void (*flex)(hb_strip *strip, bool exact);
  void (*assemble)(hb_strip *strip);
  /* Elastic forces. */
  void (*elastic)(hb_strip *strip, bool exact);
  void (*join_elastic)(hb_strip *strip);
  /* General rods. Directors carried to the new tangents and turned on; a look at the energy of turns (first:
   * at new tangents), with the elimination of Newton's system and, in `worst`, the largest dE/dtheta; the
   * turns, the longest in `left`; directors turned; forces. */
  void (*carry)(hb_strip *strip, bool exact);
  void (*look)(hb_strip *strip, bool first);
  void (*solve_turns)(hb_strip *strip);
  void (*turn)(hb_strip *strip);
  void (*drop_turns)(hb_strip *strip, int lane); /* none for this lane, -1: for all */
  void (*general)(hb_strip *strip);
  /* Uniform loads: into load, onto f, their sums into `work` and `lost`. h: time step; with predict
   * velocities are extrapolated to the end of the step, as second-order schemes want them. */
  void (*loads)(hb_strip *strip, double h, bool predict);
  /* Velocities of the second-order scheme (half-step velocities completed by the pull of lambda along the old
   * edges, then kicked), and elimination for their projection. */
  void (*eliminate_rates)(hb_strip *strip, double kick, double inv_h);
  void (*spread_rates)(hb_strip *strip);
  /* Leaves a sum in `finite` that is a number if all velocities and forces are. */
  void (*sum_up)(hb_strip *strip);
  /* Once per rod, in doubles; NULL in tables of floats. Directors carried to the directions of e; false if
   * one of them cannot be. Twist from one director to another over a rotation, and angle between directors,
   * nearest to what it was: math/rotation.h in lanes. */
  bool (*carry_directors)(hb_lane_director *list, int count);
  void (*panel_twist)(const double turn[4 * HB_LANES_DOUBLE], const hb_lane_director *from,
                      const hb_lane_director *to, double twist[HB_LANES_DOUBLE]);
  void (*director_angle)(const hb_lane_director *from, const hb_lane_director *to,
                         double angle[HB_LANES_DOUBLE]);
} hb_lane_kernels;

/* The kernels for this processor, without special instructions if they are to be portable. */
const hb_lane_kernels *hb_lane_kernels_for(bool single, bool portable);

/* One number of a row array: index counts numbers of lanes, e.g. 3*row + c. */
static inline double hb_strip_get(const hb_strip *s, const void *array, size_t index, int lane) {
  size_t k = index * (size_t)s->lanes + (size_t)lane;
  return s->single ? (double)((const float *)array)[k] : ((const double *)array)[k];
}
/* Sets it. */
static inline void hb_strip_set(const hb_strip *s, void *array, size_t index, int lane, double value) {
  size_t k = index * (size_t)s->lanes + (size_t)lane;
  if (s->single)
    ((float *)array)[k] = (float)value;
  else
    ((double *)array)[k] = value;
}

#endif
