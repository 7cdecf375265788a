/* Clamps at a rod's end: the direction in which the held edge stands (docs/theory, 2.7). */
#include "model/compile.h"

#include "math/rotation.h"

/* Turns smaller than this are round-off of the initial shape. */
#define SMALLEST_TURN 1e-10

/* Unit tangent of edge j of a polyline. */
static hb_v3 tangent_of(const double *x, int j) {
  return hb_v3_unit(hb_v3_sub(hb_v3_load(x + 3 * j + 3), hb_v3_load(x + 3 * j)));
}

/* Value of a formula of t at the start; NULL: 0. */
static double at_start(const hb_formula *f) {
  const double vars[HB_VAR_COUNT] = {0};
  return f ? hb_formula_eval(f, vars) : 0;
}

/* First director of an edge in the initial shape, if it is prescribed: only then is it known before the twist
 * is solved. */
static bool director_at_start(const hb_model *m, int r, int edge, hb_v3 *m1) {
  const hb_rod_def *def = &m->def->rods[r];
  hb_v3 t = tangent_of(def->initial, 0), u = hb_v3_load(&m->start_m1[3 * r]);
  for (int j = 1; j <= edge; j++) {
    hb_v3 next = tangent_of(def->initial, j);
    u = hb_transport(u, t, next);
    t = next;
  }
  for (int k = 0; k < def->support_count; k++) {
    const hb_support_def *s = &def->supports[k];
    int at = s->index < 0 ? s->index + def->nv - 1 : s->index;
    if (at != edge || (s->kind != HB_SUPPORT_DIRECTOR && (s->kind != HB_SUPPORT_ANGLE || s->held))) continue;
    hb_v3 d = u;
    if (s->kind == HB_SUPPORT_DIRECTOR)
      d = hb_project_normal((hb_v3){at_start(s->value[0]), at_start(s->value[1]), at_start(s->value[2])}, t);
    *m1 = hb_turn(d, t, at_start(s->angle));
    return true;
  }
  return false;
}

/* The rotation vector that takes one tangent to the next, from kb, whose size is 2 tan(phi/2). */
static hb_v3 turn_of(hb_v3 kb) {
  double size = hb_v3_norm(kb);
  return size > 0 ? hb_v3_scale(2 * atan(0.5 * size) / size, kb) : kb;
}

/* The edge stands for the rod at its middle, half an edge from the wall. The initial shape has turned there
 * by its own curvature; what is held has to have turned by that of the rest shape only: the rest of it is
 * strain, which the neighbour's cell takes. Both turns are shares of those at the neighbour. */
hb_v3 hb_compile_wall(const hb_model *m, int r, const hb_support_def *s, hb_v3 direction) {
  const hb_rod_def *def = &m->def->rods[r];
  int i = s->base_is_end ? def->nv - 2 : 1, edge = s->base_is_end ? i : 0, k = m->rods[r].first + i;
  const double *rest = &m->rest_omega[4 * k + (s->base_is_end ? 2 : 0)];
  hb_v3 a = tangent_of(def->initial, i - 1), b = tangent_of(def->initial, i), held = s->base_is_end ? b : a;
  double chi = 1 + hb_v3_dot(a, b);
  if (!(chi > HB_FOLD_LIMIT)) return direction;
  hb_v3 now = turn_of(hb_v3_scale(2 / chi, hb_v3_cross(a, b))), natural = {0, 0, 0}, m1;
  if (rest[0] != 0 || rest[1] != 0) {
    if (!director_at_start(m, r, edge, &m1)) return direction;
    natural = turn_of(hb_v3_axpy(hb_v3_scale(rest[0], hb_v3_cross(held, m1)), -rest[1], m1));
  }
  double length = m->rest_length[m->rods[r].first + edge];
  double share = length / (m->rest_length[k - 1] + m->rest_length[k]);
  hb_v3 turn = hb_v3_scale(s->base_is_end ? -share : share, hb_v3_sub(natural, now));
  double angle = hb_v3_norm(turn);
  if (!(angle > SMALLEST_TURN)) return direction;
  hb_quat q = {cos(0.5 * angle), hb_v3_scale(sin(0.5 * angle) / angle, turn)};
  return hb_v3_unit(hb_quat_rotate(q, direction));
}
