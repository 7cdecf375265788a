#include "support/lanes.h"

#include "math/vec3.h"
#include "sim/sim.h"
#include "support/rods.h"

/* ---- running ----------------------------------------------------------------------------------------------
 */

/* All ways share the model. */
void trio_start(trio *t, double step) {
  static const hb_lane_choice choice[WAY_COUNT] = {HB_LANES_OFF, HB_LANES_PORTABLE, HB_LANES_BEST,
                                                   HB_LANES_OFF};
  hb_error err = {HB_OK, ""};
  if (hb_model_create(&t->def, &t->model, &err)) fail_msg("model: %s", err.text);
  if (step > 0) t->def.method.time_step = fmin(step, 0.2 * hb_model_stable_step(t->model, NULL));
  for (int w = 0; w < WAY_COUNT; w++) {
    t->def.method.lanes = choice[w];
    t->def.method.threads = w == WAY_BEST ? 3 : 1;
    if (hb_sim_create(t->model, &t->sim[w], &err)) fail_msg("simulation: %s", err.text);
  }
  for (int k = 0; k < 2; k++)
    if (hb_frame_create(t->model, &t->frame[k], &err)) fail_msg("frame: %s", err.text);
}

/* Frees everything. */
void trio_end(trio *t) {
  for (int k = 0; k < 2; k++) hb_frame_free(t->frame[k]);
  for (int w = 0; w < WAY_COUNT; w++) hb_sim_free(t->sim[w]);
  hb_model_free(t->model);
  hb_scene_def_free(&t->def);
}

/* Is the flag of a strip set, or any byte of a number not zero? */
static bool has_array(const hb_strip *s, size_t flag) {
  return flag == offsetof(hb_strip, rows) || *((const unsigned char *)s + flag) != 0;
}

/* The end of one lane is the beginning of the next: every array of vertices has the same bits there. */
static void check_copies(const hb_unit *u) {
#define ROWS(name, numbers, kept)                                                                            \
  { offsetof(hb_strip, name), numbers, offsetof(hb_strip, kept) }
  static const struct {
    size_t offset;
    int numbers;
    size_t kept; /* flag of strips that have the array; all have some rows */
  } arrays[] = {ROWS(x, 3, rows),        ROWS(v, 3, rows),     ROWS(f, 3, rows),
                ROWS(x_old, 3, rows),    ROWS(v_old, 3, rows), ROWS(load, 3, loaded),
                ROWS(twist, 1, general), ROWS(kb, 3, general), ROWS(stress, 4, general)};
#undef ROWS
  for (int n = 0; u->pieces && n + 1 < u->strip_count * u->strips->lanes; n++) {
    const hb_strip *a = &u->strips[n / u->strips->lanes], *b = &u->strips[(n + 1) / u->strips->lanes];
    for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++)
      for (int c = 0; c < arrays[k].numbers && has_array(a, arrays[k].kept); c++) {
        void *from, *to;
        memcpy(&from, (const char *)a + arrays[k].offset, sizeof from);
        memcpy(&to, (const char *)b + arrays[k].offset, sizeof to);
        double end = hb_strip_get(a, from, (size_t)(arrays[k].numbers * a->rows + c), n % a->lanes);
        double start = hb_strip_get(b, to, (size_t)c, (n + 1) % b->lanes);
        if (memcmp(&end, &start, sizeof end) != 0)
          fail_msg("array %zu, piece %d ends with %.17g, but the next one begins with %.17g", k, n, end,
                   start);
      }
  }
}

/* One step in all ways. */
static hb_status step_all(trio *t, hb_error *err) {
  hb_error sentence[WAY_COUNT];
  hb_status status[WAY_COUNT];
  for (int w = 0; w < WAY_COUNT; w++) {
    sentence[w] = (hb_error){HB_OK, ""};
    status[w] = hb_sim_step(t->sim[w], &sentence[w]);
  }
  for (int w = 1; w < WAY_PUSHED; w++) {
    if (status[w] == status[0] && strcmp(sentence[w].text, sentence[0].text) == 0) continue;
    fail_msg("one way says %d \"%s\", the other %d \"%s\"", (int)status[0], sentence[0].text, (int)status[w],
             sentence[w].text);
  }
  *err = sentence[0];
  return status[0];
}

/* Steps, bits, copies. */
hb_status trio_run(trio *t, long steps, hb_error *err) {
  hb_error own = {HB_OK, ""};
  for (long k = 0; k < steps; k++) {
    hb_status status = step_all(t, &own);
    if (err) *err = own;
    if (status && !err) fail_msg("%s", own.text);
    if (status) return status;
    uint64_t portable = hb_state_hash(hb_sim_const_state(t->sim[WAY_PORTABLE]));
    uint64_t best = hb_state_hash(hb_sim_const_state(t->sim[WAY_BEST]));
    const double *plain = hb_sim_const_state(t->sim[WAY_PLAIN])->scalar,
                 *lanes = hb_sim_const_state(t->sim[WAY_BEST])->scalar;
    t->parted = t->parted || plain[HB_S_PROJECTIONS] != lanes[HB_S_PROJECTIONS];
    if (portable != best) fail_msg("step %ld of %ld: other bits with other instructions", k + 1, steps);
    const hb_lane_plan *plan = t->sim[WAY_BEST]->stepper.plan;
    for (int u = 0; plan && u < plan->unit_count; u++) check_copies(&plan->units[u]);
  }
  return HB_OK;
}

/* Free vertices only: prescribed ones are put back by every step. */
void trio_push(trio *t, rng *r, double size) {
  hb_state *s = hb_sim_state(t->sim[WAY_PUSHED]);
  for (int k = 0; k < 3 * t->model->nv; k++)
    if (t->model->inv_mass[k] > 0)
      s->x[k] += size * t->model->rods[t->model->rod_of[k / 3]].length * rng_uniform(r, -1, 1);
}

/* By the plan of the best way. */
bool trio_all_in_lanes(const trio *t) {
  const hb_lane_plan *plan = t->sim[WAY_BEST]->stepper.plan;
  for (int r = 0; r < t->model->rod_count; r++)
    if (!plan || plan->unit_of[r] < 0) return false;
  return true;
}

/* Is there a unit of this kind? */
static bool any_unit(const trio *t, bool pieces) {
  const hb_lane_plan *plan = t->sim[WAY_BEST]->stepper.plan;
  for (int u = 0; plan && u < plan->unit_count; u++)
    if (plan->units[u].pieces == pieces) return true;
  return false;
}

/* The two kinds. */
bool trio_any_pieces(const trio *t) { return any_unit(t, true); }
bool trio_any_bundle(const trio *t) { return any_unit(t, false); }

/* ---- comparing --------------------------------------------------------------------------------------------
 */

/* Grows *worst to the largest difference over scale. */
static void widen(double *worst, const double *a, const double *b, size_t count, double scale) {
  double d = largest_difference(a, b, count) / scale;
  if (!(d <= *worst)) *worst = d;
}

/* Sizes of one rod. */
static void compare_rod(const trio *t, const hb_rod *rod, const hb_state *a, const hb_state *b,
                        trio_gap *gap) {
  const hb_model *m = t->model;
  size_t o = (size_t)rod->first, n = (size_t)rod->nv;
  double L = rod->length, stiff = 0, beta = 0, load = 0;
  for (size_t k = o + 1; k + 1 < o + n; k++) {
    stiff = fmax(stiff, m->bend_gain[k] * m->inv_rest_length[k] * m->inv_rest_length[k]);
    beta = fmax(beta, m->beta[k] / L);
  }
  for (int f = rod->first_span; f < rod->first_span + rod->span_count; f++)
    load = fmax(load, fabs(a->moment[f]) / L);
  if (t->sim[WAY_PLAIN]->stepper.rates[rod->index]) /* drag takes velocities from differences of positions */
    for (size_t k = o; k < o + n; k++) load = fmax(load, m->mass[k] * L / m->def->method.time_step);
  widen(&gap->x, a->x + 3 * o, b->x + 3 * o, 3 * n, L);
  widen(&gap->v, a->v + 3 * o, b->v + 3 * o, 3 * n, L / m->def->method.time_step);
  widen(&gap->force, a->force + 3 * o, b->force + 3 * o, 3 * n, stiff * L + load);
  if (rod->twist_free) return;
  /* General rods: dE/dtheta of each edge is solved to round-off of 2 beta/l, n times beta/L, and the Hessian
   * is conditioned like n^2. */
  double edges = rod->closed_form ? 1 : (double)n;
  if (!rod->closed_form) {
    widen(&gap->twist, a->m1 + 3 * o, b->m1 + 3 * o, 3 * n, edges * edges);
    widen(&gap->twist, a->twist + o, b->twist + o, n, edges * edges);
  }
  widen(&gap->twist, a->moment + rod->first_span, b->moment + rod->first_span, (size_t)rod->span_count, beta);
  widen(&gap->twist, a->frame_torque + rod->first_frame, b->frame_torque + rod->first_frame,
        (size_t)rod->frame_count, edges * beta);
  widen(&gap->twist, a->frame_angle + rod->first_frame, b->frame_angle + rod->first_frame,
        (size_t)rod->frame_count, 1);
  widen(&gap->twist, &a->theta_0[rod->index], &b->theta_0[rod->index], 1, edges * edges);
  for (int f = rod->first_span; f < rod->first_span + rod->span_count; f++)
    widen(&gap->twist, a->panel_twist + m->spans[f].first_panel, b->panel_twist + m->spans[f].first_panel,
          (size_t)m->spans[f].panel_count, 1);
}

/* All energies of a frame, by size. */
static double energies(const hb_frame *f) {
  return f->kinetic + f->bending + f->twisting + fabs(f->work_loads) + fabs(f->work_supports) +
         fabs(f->dissipated) + 1e-30;
}

/* Rods, then totals. */
trio_gap trio_compare(const trio *t, int a, int b) {
  trio_gap gap = {0};
  const hb_state *p = hb_sim_const_state(t->sim[a]), *q = hb_sim_const_state(t->sim[b]);
  for (int r = 0; r < t->model->rod_count; r++) compare_rod(t, &t->model->rods[r], p, q, &gap);
  hb_sim_measure(t->sim[a], t->frame[0]);
  hb_sim_measure(t->sim[b], t->frame[1]);
  const hb_frame *f = t->frame[0], *g = t->frame[1];
  double one[7] = {f->work_loads, f->work_supports, f->dissipated, f->kinetic,
                   f->bending,    f->twisting,      f->balance};
  double two[7] = {g->work_loads, g->work_supports, g->dissipated, g->kinetic,
                   g->bending,    g->twisting,      g->balance};
  widen(&gap.energy, one, two, 7, energies(f));
  assert_int_equal(p->scalar[HB_S_STEP], q->scalar[HB_S_STEP]);
  assert_same(p->scalar[HB_S_TIME], q->scalar[HB_S_TIME]);
  return gap;
}

/* Ten times, and a floor. */
trio_gap trio_bound(trio_gap p) {
  return (trio_gap){10 * p.x + 1e-13, 10 * p.v + 1e-13, 10 * p.force + 1e-12, 10 * p.twist + 1e-12,
                    10 * p.energy + 1e-11};
}

/* One by one. */
void trio_check(trio_gap gap, trio_gap allowed, const char *what) {
  const double found[5] = {gap.x, gap.v, gap.force, gap.twist, gap.energy};
  const double bound[5] = {allowed.x, allowed.v, allowed.force, allowed.twist, allowed.energy};
  static const char *const names[5] = {"positions", "velocities", "forces", "twist", "energies"};
  for (int k = 0; k < 5; k++)
    if (!(found[k] <= bound[k]))
      fail_msg("%s: %s differ by %.3g, allowed %.3g", what, names[k], found[k], bound[k]);
}

/* On one line. */
void trio_say(const char *what, trio_gap g) {
  say("  %-10s positions %.1e velocities %.1e forces %.1e twist %.1e energies %.1e\n", what, g.x, g.v,
      g.force, g.twist, g.energy);
}

/* ---- random scenes ----------------------------------------------------------------------------------------
 */

/* Frames of the inner clamps, in different halves of the rod; with a vertex held there. */
static void add_inner(hb_rod_def *rod, rng *r) {
  int last = rod->nv - 2;
  scene_hold(rod, 0);
  scene_angle(rod, 0, "0");
  if (last > 3) scene_angle(rod, rng_int(r, 1, last / 2), "0.4 + t");
  if (last > 4) scene_angle(rod, rng_int(r, last / 2 + 1, last - 1), "-0.3");
  if (rng_int(r, 0, 1)) scene_angle(rod, -1, "1 + 2*sin(t)");
  if (last > 8 && rng_int(r, 0, 1)) scene_hold(rod, last / 2);
}

/* Moving supports: one end on a path with a guided tangent, or two ends on paths. */
static void add_carried(hb_rod_def *rod, rng *r) {
  scene_path(rod, 0, "x + 0.05*sin(3*t^2)", "y + 0.1*t^2", NULL);
  if (rng_int(r, 0, 1)) {
    char text[3][64];
    for (int c = 0; c < 3; c++)
      snprintf(text[c], sizeof text[c], "%.17g + %g*t", rod->initial[3 + c] - rod->initial[c],
               0.05 * (c - 1));
    scene_tangent(rod, 0, text[0], text[1], text[2], false);
    scene_angle(rod, 0, "2*t");
  } else if (rod->nv > 5) {
    scene_path(rod, -1, NULL, "y + 0.03*(1 - cos(6*t))", "z");
    scene_director(rod, -1, "cos(t)", "sin(t)", "0.6", "0.5*t");
    scene_angle(rod, rng_int(r, 0, 1), "0");
  }
}

/* Supports of a kind. */
static void add_supports(hb_rod_def *rod, rng *r, lane_ends ends) {
  switch (ends) {
  case LANE_PINNED:
    scene_hold(rod, rng_int(r, 0, 1) ? 0 : rod->nv - 1);
    if (rod->nv > 6) scene_hold(rod, rod->nv / 2);
    break;
  case LANE_CLAMPED: scene_clamp_start(rod); break;
  case LANE_BOTH_CLAMPED:
    scene_clamp_start(rod);
    if (rod->nv > 4) scene_hold(rod, -1);
    if (rod->nv > 5) scene_hold(rod, -2);
    scene_angle(rod, -1, rng_int(r, 0, 1) ? "25 + 30*t" : "-9*(1 - cos(5*t)) + 1");
    break;
  case LANE_INNER: add_inner(rod, r); break;
  case LANE_CARRIED: add_carried(rod, r); break;
  case LANE_FREE:
  case LANE_ENDS: break;
  }
}

/* Unit length, unit mass, or nearly; moves by about its length in one unit of time. */
void lanes_add_rod(hb_scene_def *def, rng *r, int nv, lane_ends ends) {
  double *lengths = hb_alloc((size_t)nv, sizeof *lengths), *x = hb_alloc(3 * (size_t)nv, sizeof *x);
  double *v = hb_alloc(3 * (size_t)nv, sizeof *v), a[3], b[3],
         uneven = rng_int(r, 0, 2) ? rng_uniform(r, 0, 0.6) : 0;
  assert_true(lengths && x && v);
  double L = rng_uniform(r, 0.5, 2), phase = rng_uniform(r, 0, 6),
         soft = 1.0 / nv / nv / (nv > 100 ? nv : 100);
  for (int j = 0; j + 1 < nv; j++) lengths[j] = L / (nv - 1) * (1 + uneven * sin(1.7 * j + phase));
  rod_random_shape(r, nv, lengths, fmin(0.5, 6.0 / nv), x);
  hb_rod_def *rod = scene_rod(def, nv, x, 1, 1, 1);
  char name[32];
  snprintf(name, sizeof name, "rod%d", def->rod_count);
  hb_free(rod->name);
  rod->name = hb_strdup(name);
  rod->straight_rest = true;
  rng_direction(r, rod->first_director);
  double alpha = soft * exp(rng_uniform(r, -2, 2)), beta = alpha * rng_uniform(r, 0.3, 1.5);
  bool varying = rng_int(r, 0, 1);
  rng_direction(r, a);
  rng_direction(r, b);
  for (int i = 0; i < nv; i++) {
    double s = (double)i / (nv - 1), more = varying ? 1 + 0.7 * sin(5 * s + phase) : 1;
    rod->mass[i] = (varying ? 1 + 0.5 * cos(9 * s) : 1) / nv;
    rod->beta[i] = beta * more;
    if (i + 1 < nv) rod->B[3 * i] = rod->B[3 * i + 2] = alpha * more;
    for (int c = 0; c < 3; c++)
      v[3 * i + c] = 0.5 * a[c] + s * s * b[c] + 0.3 * sin(4 * s + c) * a[(c + 1) % 3];
  }
  bool whips = ends == LANE_CARRIED || (ends != LANE_FREE && nv > 100); /* a jump of velocity at a support */
  if (!whips && rng_int(r, 0, 3)) scene_velocity(rod, v);
  if (rng_int(r, 0, 2) == 0) rod->mass_damping = rng_uniform(r, 0, 2);
  add_supports(rod, r, ends);
  hb_free(lengths);
  hb_free(x);
  hb_free(v);
}

/* Rest lengths stay what they are. */
void lanes_make_general(hb_scene_def *def, rng *r) {
  hb_rod_def *rod = &def->rods[def->rod_count - 1];
  int nv = rod->nv, kind = rng_int(r, 1, 7);
  double *lengths = hb_alloc((size_t)nv, sizeof *lengths), turn = rng_uniform(r, 0, 3),
         cross = rng_uniform(r, 0, 0.4);
  assert_non_null(lengths);
  for (int j = 0; j + 1 < nv; j++)
    lengths[j] = hb_v3_norm(hb_v3_sub(hb_v3_load(rod->rest + 3 * j + 3), hb_v3_load(rod->rest + 3 * j)));
  if (kind & 1)
    for (int j = 0; j + 1 < nv; j++) {
      rod->B[3 * j + 1] = cross * rod->B[3 * j];
      rod->B[3 * j + 2] *= 0.6;
    }
  rod->straight_rest = !(kind & 2);
  if (kind & 2) rod_random_shape(r, nv, lengths, fmin(0.4, 4.0 / nv), rod->rest);
  if (kind & 4) {
    rod->natural_twist = scene_fill(turn, (size_t)nv);
    if (kind == 4) rod->B[3 * (nv / 2) - 1] *= 1.5; /* else it would be an isotropic straight rod after all */
  }
  hb_free(lengths);
}

/* Not all of them always. */
void lanes_add_loads(hb_scene_def *def, rng *r) {
  if (rng_int(r, 0, 3)) scene_force(def, HB_FORCE_GRAVITY, "0.3", "0", "-1.5");
  if (rng_int(r, 0, 2) == 0) {
    hb_force_def *wind = scene_force(def, HB_FORCE_WIND, "0.1 + 0.2*z", "0.8*cos(t)", "0.2*x");
    wind->linear[0] = 0.3;
    wind->linear[1] = 0.1;
    wind->quadratic[0] = 0.4;
    wind->quadratic[1] = 0.05;
  }
  if (rng_int(r, 0, 1)) {
    hb_force_def *point = scene_force(def, HB_FORCE_POINT, "0.1", "0.2*sin(3*t)", "0.1*x");
    point->rod = rng_int(r, 0, def->rod_count - 1);
    point->vertex = rng_int(r, 0, def->rods[point->rod].nv - 1);
  }
  if (rng_int(r, 0, 3) == 0) scene_force(def, HB_FORCE_DISTRIBUTED, "0.1", "0.3*s*x", "0.1*cos(t) + z");
}
