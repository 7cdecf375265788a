/* The largest step that the explicit schemes bear: from the fastest oscillation that the vertices can carry
 * (docs/theory/7-integrators.md, 7.6) and the fastest damping. */
#include "hebra/model.h"
#include "math/rotation.h"

#include <math.h>
#include <string.h>

#define TIMES 100

/* Formulas' values at a vertex of the initial shape at time t. */
static hb_v3 value_at(const hb_model *m, hb_formula *const value[3], int k, double t, double *speed) {
  const hb_rod *rod = &m->rods[m->rod_of[k]];
  double vars[HB_VAR_COUNT] = {0}, out[3] = {0, 0, 0}, rate[3] = {0, 0, 0};
  vars[HB_VAR_T] = t;
  vars[HB_VAR_S] = m->arc[k];
  vars[HB_VAR_U] = rod->length > 0 ? m->arc[k] / rod->length : 0;
  vars[HB_VAR_I] = k - rod->first;
  vars[HB_VAR_L] = rod->length;
  for (int c = 0; c < 3; c++) vars[HB_VAR_X + c] = m->initial[3 * k + c];
  for (int c = 0; c < 3; c++) {
    if (value[c] && speed) hb_formula_eval_dt(value[c], vars, &out[c], &rate[c]);
    if (value[c] && !speed) out[c] = hb_formula_eval(value[c], vars);
  }
  if (speed) *speed = hb_v3_norm(hb_v3_load(rate));
  return hb_v3_load(out);
}

/* Largest twisting moment that the prescribed angles put into a span during the run: the twist over its
 * compliance. */
static double span_moment(const hb_model *m, const hb_span *s) {
  double most = 0;
  const hb_rod_def *rod = &m->def->rods[s->rod];
  if (rod->closing != HB_CLOSING_NONE && s->panel_count > 0) {
    double twist = rod->closing_value * (rod->closing == HB_CLOSING_TWIST ? 1 : 2 * HB_PI);
    return fabs(twist - s->natural_twist) / s->compliance;
  }
  if (s->first_frame < 0 || s->last_frame < 0 || !(s->compliance > 0)) return 0;
  for (int k = 0; k <= TIMES; k++) {
    double vars[HB_VAR_COUNT] = {0}, angle[2] = {0, 0};
    const hb_formula *formula[2] = {m->frames[s->first_frame].def->angle,
                                    m->frames[s->last_frame].def->angle};
    vars[HB_VAR_T] = m->def->method.duration * k / TIMES;
    for (int e = 0; e < 2; e++)
      if (formula[e]) angle[e] = hb_formula_eval(formula[e], vars);
    double twist = angle[1] - angle[0] - s->natural_twist;
    if (isfinite(twist)) most = fmax(most, fabs(twist) / s->compliance);
  }
  return most;
}

/* Sum of the sizes of a rod's loads at the start. On a rod that is not held anywhere gravity pulls nothing.
 */
static double load_on(const hb_model *m, const hb_rod *rod) {
  const hb_scene_def *def = m->def;
  double sum = 0;
  for (int n = 0; n < def->force_count; n++) {
    const hb_force_def *f = &def->forces[n];
    if (!hb_force_def_acts_on(f, rod->index) || f->kind == HB_FORCE_WIND) continue;
    if (f->kind == HB_FORCE_GRAVITY && rod->position_count == 0) continue;
    int from = rod->first, to = rod->first + rod->nv - 1;
    if (f->kind == HB_FORCE_POINT) from = to = rod->first + (f->vertex < 0 ? f->vertex + rod->nv : f->vertex);
    for (int k = from; k <= to && k >= rod->first && k < rod->first + rod->nv; k++) {
      double size = hb_v3_norm(value_at(m, f->value, k, 0, NULL));
      if (f->kind == HB_FORCE_GRAVITY) size *= m->mass[k];
      if (f->kind == HB_FORCE_DISTRIBUTED) size *= m->weight[k];
      if (isfinite(size)) sum += size;
    }
  }
  return sum;
}

/* Largest speed that the start, against the mean of all vertices, or a support gives to a vertex. */
static double speed_of(const hb_model *m, const hb_rod *rod) {
  const double *v = m->def->rods[rod->index].velocity;
  hb_v3 mean = {0, 0, 0};
  double most = 0;
  for (int i = 0; v && i < rod->nv; i++) mean = hb_v3_axpy(mean, 1.0 / rod->nv, hb_v3_load(v + 3 * i));
  for (int i = 0; v && i < rod->nv; i++)
    most = fmax(most, hb_v3_norm(hb_v3_sub(hb_v3_load(v + 3 * i), mean)));
  for (int n = rod->first_position; n < rod->first_position + rod->position_count; n++) {
    const hb_position_support *p = &m->positions[n];
    for (int k = 0; !p->tangent && k <= TIMES; k++) {
      double speed = 0;
      (void)value_at(m, p->def->value, p->slot, m->def->method.duration * k / TIMES, &speed);
      if (isfinite(speed)) most = fmax(most, speed);
    }
  }
  return most;
}

/* Larger principal value of the bending form of an edge. */
static double stiff_side(const double *B) { return 0.5 * (B[0] + B[2]) + hypot(0.5 * (B[0] - B[2]), B[1]); }

/* Is there wind on the rod? */
static bool windy(const hb_scene_def *def, int rod) {
  for (int i = 0; i < def->force_count; i++)
    if (def->forces[i].kind == HB_FORCE_WIND && hb_force_def_acts_on(&def->forces[i], rod)) return true;
  return false;
}

/* Rate of damping: mass-proportional, and of wind, whose quadratic part has the slope 2 q |w| at the relative
 * speed |w| of the start. */
static double damping_rate(const hb_model *m, const hb_rod *rod, bool wind, int k) {
  const hb_scene_def *def = m->def;
  const hb_rod_def *own = &def->rods[rod->index];
  double rate = own->mass_damping;
  for (int i = 0; wind && i < def->force_count; i++) {
    const hb_force_def *f = &def->forces[i];
    if (f->kind != HB_FORCE_WIND || !hb_force_def_acts_on(f, rod->index)) continue;
    double speed = hb_v3_norm(value_at(m, f->value, k, 0, NULL));
    double drag = fmax(f->linear[0], f->linear[1]);
    if (isfinite(speed))
      drag += 2 * speed * fmax(hb_force_def_quadratic(f, own, 0), hb_force_def_quadratic(f, own, 1));
    rate += drag * m->weight[k] / m->mass[k];
  }
  return rate;
}

/* What a damping rate counts for: Euler bears h times rate < 2; Verlet, which takes damping at extrapolated
 * velocities, h times rate < 1 (its growth factor solves z^2 - (1 - 1.5 a) z - a/2 = 0 with a = h rate, z =
 * -1 at a = 1). */
static double damping_weight(const hb_model *m) {
  const char *name = m->def->method.integrator;
  return name && strcmp(name, "symplectic-euler") == 0 ? 0.5 : 1;
}

/* Limit of one rod: the smallest over its vertices. Bending waves of the shortest length have 16 B/(rho A
 * l^4), twist adds at most 2.6 M/(rho A l^3), tension 4 T/(rho A l^2) to the square of the frequency;
 * waves of stretching have 4 E A/(rho A l^2). With
 * the rate c of viscosity the limit is h^2 Omega^2 + 4 h c = 4. */
static double rod_limit(const hb_model *m, const hb_rod *rod) {
  double limit = HUGE_VAL, load = load_on(m, rod), speed = speed_of(m, rod);
  bool wind = windy(m->def, rod->index);
  for (int p = rod->first_span; p < rod->first_span + rod->span_count; p++) {
    const hb_span *span = &m->spans[p];
    double moment = span_moment(m, span);
    for (int k = span->first_edge + 1; k <= span->last_edge; k++) {
      double l = 0.5 * m->voronoi[k], l2 = l * l, per_length = m->mass[k] / m->weight[k];
      double B = fmax(stiff_side(&m->B[3 * k - 3]), stiff_side(&m->B[3 * k]));
      double pull = load + per_length * speed * speed;
      double square = (16 * B / (l2 * l2) + 2.6 * moment / (l2 * l) + 4 * pull / l2) / per_length;
      /* waves along an extensible rod are another motion than those across it */
      double wave = 4 * fmax(m->stretching[k - 1], m->stretching[k]) / (l2 * per_length);
      square = fmax(square, wave);
      double rate = 16 * fmax(m->viscosity[k - 1], m->viscosity[k]) / (l2 * l2 * per_length) +
                    damping_weight(m) * damping_rate(m, rod, wind, k);
      double fastest = rate + sqrt(rate * rate + square);
      if (fastest > 0) limit = fmin(limit, 2 / fastest);
    }
  }
  return limit;
}

/* All rods. */
double hb_model_stable_step(const hb_model *model, int *rod) {
  double limit = HUGE_VAL;
  if (rod) *rod = 0;
  if (hb_method_is_implicit(&model->def->method)) return limit;
  for (int r = 0; r < model->rod_count; r++) {
    double own = rod_limit(model, &model->rods[r]);
    if (!(own < limit)) continue;
    limit = own;
    if (rod) *rod = r;
  }
  return limit;
}
