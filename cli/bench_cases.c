/* The rods that `hebra bench` steps, made without a scene file: also the counting tools in bench/ link this.
 */
#include "base/memory.h"
#include "cli/bench.h"

#include <math.h>
#include <string.h>

/* Edges per helical turn, and the helix: every edge about 0.01 long. */
#define EDGES_PER_TURN 20
#define RADIUS 0.03
#define PITCH 0.06
/* The axis is bent to a circle that a long rod runs through again and again: coordinates stay of the size of
 * this radius, else those of a million edges would be too coarse for lengths of 1e-10. */
#define CIRCLE 3.0
#define PI 3.14159265358979323846

/* Vertices of rod r. */
int cli_bench_vertices(const cli_bench_case *c, int r) {
  return c->vertices ? c->vertices : 20 + r * 37 % 61;
}

/* The helix, at rest and at the start. It begins at the origin: floats have room only for coordinates that
 * are not much larger than the rod. */
static void place(int n, double *x) {
  for (int i = 0; i < n; i++) {
    double a = 2 * PI * i / EDGES_PER_TURN, b = PITCH / EDGES_PER_TURN * i / CIRCLE;
    double reach = CIRCLE + RADIUS * cos(a);
    x[3 * i] = reach * cos(b) - (CIRCLE + RADIUS);
    x[3 * i + 1] = reach * sin(b);
    x[3 * i + 2] = RADIUS * sin(a);
  }
}

/* Masses, moduli, velocities. Every rod is shaken by other waves, so that no two have the same work to do. */
static void fill(const cli_bench_case *c, int r, hb_rod_def *rod) {
  double s = 0, before = 0;
  for (int i = 0; i < rod->nv; i++) {
    const double *x = rod->rest + 3 * i;
    double edge = i + 1 < rod->nv ? hypot(hypot(x[3] - x[0], x[4] - x[1]), x[5] - x[2]) : 0;
    rod->mass[i] = 0.05 * 0.5 * (before + edge);
    rod->beta[i] = 0.015;
    rod->velocity[3 * i] = sin(50 * s + r);
    rod->velocity[3 * i + 1] = cos(70 * s - r);
    rod->velocity[3 * i + 2] = sin(90 * s + 2 * r);
    if (i + 1 < rod->nv) {
      rod->B[3 * i] = 0.02;
      rod->B[3 * i + 2] = c->general ? 0.03 : 0.02;
    }
    before = edge;
    s += edge;
  }
}

/* Both ends held, the first frame turned by half a turn per helical turn against the last. */
static hb_status hold(hb_rod_def *rod, hb_error *err) {
  rod->supports = hb_alloc(4, sizeof *rod->supports);
  if (!rod->supports) return hb_fail_memory(err, "supports");
  hb_status status = HB_OK;
  for (int k = 0; k < 4; k++) {
    hb_support_def *s = &rod->supports[k];
    hb_support_def_init(s);
    rod->support_count = k + 1;
    s->kind = k < 2 ? HB_SUPPORT_POSITION : HB_SUPPORT_ANGLE;
    s->index = k % 2 ? -1 : 0;
    s->held = k < 2;
    double angle = k == 2 ? PI * (rod->nv - 1) / EDGES_PER_TURN : 0;
    if (k >= 2 && !status) status = hb_formula_constant(angle, &s->angle, err);
  }
  return status;
}

/* One rod: a helix held at both ends, twisted and shaken. The isotropic one is straight at rest and unwinds,
 * the general one is curved at rest: bending, twist and lengths have the same work to do at every place,
 * whatever the length. */
static hb_status make_rod(const cli_bench_case *c, int r, hb_rod_def *rod, hb_error *err) {
  size_t n = (size_t)cli_bench_vertices(c, r);
  hb_rod_def_init(rod);
  rod->nv = (int)n;
  rod->straight_rest = !c->general;
  rod->rest = hb_alloc(3 * n, sizeof(double));
  rod->initial = hb_alloc(3 * n, sizeof(double));
  rod->velocity = hb_alloc(3 * n, sizeof(double));
  rod->mass = hb_alloc(n, sizeof(double));
  rod->beta = hb_alloc(n, sizeof(double));
  rod->B = hb_alloc(3 * (n - 1), sizeof(double));
  if (!rod->rest || !rod->initial || !rod->velocity || !rod->mass || !rod->beta || !rod->B)
    return hb_fail_memory(err, "rod");
  place(rod->nv, rod->rest);
  memcpy(rod->initial, rod->rest, 3 * n * sizeof(double));
  fill(c, r, rod);
  return hold(rod, err);
}

/* The scene; the step is a quarter of the explicit limit. */
static hb_status make_scene(const cli_bench_case *c, hb_scene_def *def, hb_error *err) {
  hb_scene_def_init(def);
  def->method.time_step = 2e-5;
  def->method.duration = 1e6;
  def->method.lanes = cli_lanes();
  def->method.integrator = hb_strdup(c->integrator);
  def->rods = hb_alloc((size_t)c->rods, sizeof *def->rods);
  if (!def->method.integrator || !def->rods) return hb_fail_memory(err, "scene");
  def->method.threads = c->threads;
  def->method.precision = c->single ? HB_PRECISION_SINGLE : HB_PRECISION_DOUBLE;
  /* what an animation asks for, and floats can give: of both precisions, so that they have the same work */
  if (c->group && strcmp(c->group, "precision") == 0) def->method.length_tolerance = 1e-4;
  hb_status status = HB_OK;
  for (int r = 0; !status && r < c->rods; r++) {
    def->rod_count = r + 1;
    status = make_rod(c, r, &def->rods[r], err);
  }
  return status;
}

/* Scene, model, simulation. */
hb_status cli_bench_start(const cli_bench_case *c, cli_bench_run *run, hb_error *err) {
  memset(run, 0, sizeof *run);
  hb_status status = make_scene(c, &run->def, err);
  if (!status) status = hb_model_create(&run->def, &run->model, err);
  if (!status) status = hb_sim_create(run->model, &run->sim, err);
  return status;
}

/* Frees all of it. */
void cli_bench_stop(cli_bench_run *run) {
  hb_sim_free(run->sim);
  hb_model_free(run->model);
  hb_scene_def_free(&run->def);
}
