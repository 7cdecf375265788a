/* Rules about the numbers of a scene, each with its sentence. Rules about keys and words are the scene
 * reader's. */
#include "model/compile.h"

#include "math/rotation.h"

#include <string.h>

/* Loads: finite coefficients, existing rods and vertices. */
static hb_status check_force(const hb_scene_def *def, int k, hb_error *err) {
  const hb_force_def *f = &def->forces[k];
  if (f->rod < -1 || f->rod >= def->rod_count)
    return hb_compile_fail(def, f->line, f->column, err,
                           "forces[%d]: rod %d does not exist; there are %d rods", k, f->rod, def->rod_count);
  if (f->rods < 0 || f->rods > def->rod_count - (f->rod > 0 ? f->rod : 0))
    return hb_compile_fail(def, f->line, f->column, err,
                           "forces[%d]: %d rods from rod %d on do not exist; there are %d rods", k, f->rods,
                           f->rod, def->rod_count);
  for (int r = 0; f->kind == HB_FORCE_POINT && r < def->rod_count; r++) {
    int nv = def->rods[r].nv;
    if (hb_force_def_acts_on(f, r) && (f->vertex >= nv || f->vertex < -nv))
      return hb_compile_fail(def, f->line, f->column, err,
                             "forces[%d]: vertex %d does not exist; %s has vertices 0 .. %d", k, f->vertex,
                             def->rods[r].name ? def->rods[r].name : "the rod", nv - 1);
  }
  for (int c = 0; c < 2; c++)
    if (!(f->linear[c] >= 0 && isfinite(f->linear[c])) ||
        !(f->quadratic[c] >= 0 && isfinite(f->quadratic[c])) ||
        !(f->per_radius[c] >= 0 && isfinite(f->per_radius[c])))
      return hb_compile_fail(def, f->line, f->column, err,
                             "forces[%d]: drag coefficients must be finite and >= 0", k);
  return HB_OK;
}

/* Smallest relative length tolerance: a few times the round-off of a squared length. */
double hb_compile_least_tolerance(const hb_method_def *method) {
  return method->precision == HB_PRECISION_SINGLE ? 1e-6 : 1e-14;
}

/* What only implicit schemes can do, and what they cannot. */
static hb_status check_implicit(const hb_scene_def *def, hb_error *err) {
  const hb_method_def *m = &def->method;
  bool implicit = hb_method_is_implicit(m);
  if (!(m->error_tolerance >= 0 && isfinite(m->error_tolerance)))
    return hb_compile_fail(def, m->line, m->column, err,
                           "method.error_tolerance: %g is not allowed; it must be > 0, or 0 for none",
                           m->error_tolerance);
  if (m->error_tolerance > 0 && !implicit)
    return hb_compile_fail(def, m->line, m->column, err,
                           "method.error_tolerance: only the integrators implicit and backward-euler control "
                           "their error");
  if (implicit && m->precision == HB_PRECISION_SINGLE)
    return hb_compile_fail(def, m->line, m->column, err,
                           "method.precision: implicit schemes need double; single goes with verlet and "
                           "symplectic-euler");
  return HB_OK;
}

/* Method, output and loads. */
hb_status hb_compile_check_scene(const hb_scene_def *def, hb_error *err) {
  const hb_method_def *m = &def->method;
  if (def->rod_count < 1)
    return hb_compile_fail(def, 0, 0, err, "the scene has no rods; at least one is needed");
  if (!(m->time_step > 0 && isfinite(m->time_step)))
    return hb_compile_fail(def, m->line, m->column, err,
                           "method.time_step: %g is not allowed; it must be > 0", m->time_step);
  if (!(m->duration >= 0 && isfinite(m->duration)))
    return hb_compile_fail(def, m->line, m->column, err,
                           "method.duration: %g is not allowed; it must be >= 0", m->duration);
  if (m->duration / m->time_step > 1e12)
    return hb_compile_fail(def, m->line, m->column, err,
                           "method: %g steps are too many; at most 1e12 are possible",
                           m->duration / m->time_step);
  hb_status status = check_implicit(def, err);
  if (status) return status;
  if (!(m->length_tolerance > 0 && isfinite(m->length_tolerance)))
    return hb_compile_fail(def, m->line, m->column, err,
                           "method.length_tolerance: %g is not allowed; it must be > 0", m->length_tolerance);
  bool single = m->precision == HB_PRECISION_SINGLE;
  double least = hb_compile_least_tolerance(m);
  if (m->length_tolerance_kind == HB_TOLERANCE_RELATIVE && m->length_tolerance < least)
    return hb_compile_fail(
        def, m->line, m->column, err,
        "method.length_tolerance: %g is below what %s precision can hold; at least %g is needed%s",
        m->length_tolerance, single ? "single" : "double", least, single ? ", or precision: double" : "");
  if (m->threads < 0)
    return hb_compile_fail(def, 0, 0, err,
                           "%d threads are not possible; at least 1, or 0 to let the program "
                           "choose, is expected",
                           m->threads);
  if (m->max_projections < 1 || m->max_twist_iterations < 1)
    return hb_compile_fail(def, m->line, m->column, err, "method: iteration limits must be >= 1");
  if (def->output.every < 1)
    return hb_compile_fail(def, 0, 0, err, "output.every: %d is not allowed; it must be >= 1",
                           def->output.every);
  for (int k = 0; k < def->force_count; k++) {
    status = check_force(def, k, err);
    if (status) return status;
  }
  return HB_OK;
}

/* An array of a rod: every entry finite (and >= 0, > 0 where asked: sign 1, 2). */
static hb_status check_array(const hb_scene_def *def, const hb_rod_def *r, const char *what, const double *a,
                             int count, int sign, hb_error *err) {
  for (int k = 0; a && k < count; k++) {
    bool good = isfinite(a[k]) && (sign == 0 || (sign == 1 ? a[k] >= 0 : a[k] > 0));
    if (!good)
      return hb_compile_fail(def, r->line, r->column, err, "rod %s: %s at index %d is %g; it must be %s",
                             r->name ? r->name : "?", what, k, a[k],
                             sign == 0   ? "finite"
                             : sign == 1 ? "finite and >= 0"
                                         : "finite and > 0");
  }
  return HB_OK;
}

/* Edges of a polyline: none of length zero. */
static hb_status check_edges(const hb_scene_def *def, const hb_rod_def *r, const char *what, const double *x,
                             hb_error *err) {
  for (int j = 0; j + 1 < r->nv; j++) {
    hb_v3 e = hb_v3_sub(hb_v3_load(x + 3 * j + 3), hb_v3_load(x + 3 * j));
    if (!(hb_v3_norm(e) > 0))
      return hb_compile_fail(def, r->line, r->column, err, "rod %s: edge %d of the %s shape has length zero",
                             r->name ? r->name : "?", j, what);
  }
  return HB_OK;
}

/* B^j positive semi-definite. */
static hb_status check_forms(const hb_scene_def *def, const hb_rod_def *r, hb_error *err) {
  for (int j = 0; j + 1 < r->nv; j++) {
    double b11 = r->B[3 * j], b12 = r->B[3 * j + 1], b22 = r->B[3 * j + 2];
    if (b11 < 0 || b22 < 0 || b12 * b12 > b11 * b22 * (1 + 1e-12))
      return hb_compile_fail(
          def, r->line, r->column, err,
          "rod %s: the bending form of edge %d, ((%g, %g), (%g, %g)), is not positive semi-definite",
          r->name ? r->name : "?", j, b11, b12, b12, b22);
  }
  return HB_OK;
}

/* Vertex where a polyline folds back onto itself, or -1. closed: the last edge is followed by the first. */
static int find_fold(const double *x, int nv, bool closed) {
  for (int i = 1; i + (closed ? 0 : 1) < nv; i++) {
    const double *next = i + 1 < nv ? x + 3 * i + 3 : x + 3;
    hb_v3 a = hb_v3_unit(hb_v3_sub(hb_v3_load(x + 3 * i), hb_v3_load(x + 3 * i - 3)));
    hb_v3 b = hb_v3_unit(hb_v3_sub(hb_v3_load(next), hb_v3_load(x + 3 * i)));
    if (!(1 + hb_v3_dot(a, b) > HB_FOLD_LIMIT)) return i;
  }
  return -1;
}

/* Curvature is infinite at a fold: no rest shape may have one, and no initial shape of a rod that resists
 * bending. */
static hb_status check_folds(const hb_scene_def *def, const hb_rod_def *r, hb_error *err) {
  bool stiff = false, closed = r->closing != HB_CLOSING_NONE;
  bool rest_closed = closed && hb_compile_is_closed(r->rest, r->nv);
  for (int k = 0; k < 3 * (r->nv - 1); k++) stiff = stiff || r->B[k] != 0;
  int rest = r->straight_rest ? -1 : find_fold(r->rest, r->nv, rest_closed),
      initial = stiff ? find_fold(r->initial, r->nv, closed) : -1;
  if (rest < 0 && initial < 0) return HB_OK;
  return hb_compile_fail(
      def, r->line, r->column, err,
      "rod %s: the %s shape folds back onto itself at vertex %d; its curvature there is infinite",
      r->name ? r->name : "?", rest >= 0 ? "rest" : "initial", rest >= 0 ? rest : initial);
}

/* Is the last vertex of a polyline its first? */
bool hb_compile_is_closed(const double *x, int nv) {
  const double *last = x + 3 * (size_t)(nv - 1);
  return x[0] == last[0] && x[1] == last[1] && x[2] == last[2];
}

/* What a closed rod must be like. */
static hb_status check_closed(const hb_scene_def *def, const hb_rod_def *r, hb_error *err) {
  const char *name = r->name ? r->name : "?";
  const double *a = r->initial, *b = r->initial + 3 * (size_t)(r->nv - 1);
  if (r->closing == HB_CLOSING_NONE) return HB_OK;
  if (r->nv < 4)
    return hb_compile_fail(def, r->line, r->column, err,
                           "rod %s: a closed rod of %d edges is not possible; at least 3 are needed", name,
                           r->nv - 1);
  if (!hb_compile_is_closed(r->initial, r->nv))
    return hb_compile_fail(
        def, r->line, r->column, err,
        "rod %s: the rod is closed, but its initial shape ends at (%g, %g, %g) and begins at "
        "(%g, %g, %g); both must be the same",
        name, b[0], b[1], b[2], a[0], a[1], a[2]);
  if (!isfinite(r->closing_value))
    return hb_compile_fail(def, r->line, r->column, err,
                           "rod %s: the twist with which the rod is closed is %g; it must be finite", name,
                           r->closing_value);
  return HB_OK;
}

/* All rules of one rod. */
hb_status hb_compile_check_rod(const hb_scene_def *def, int rod, hb_error *err) {
  const hb_rod_def *r = &def->rods[rod];
  if (r->nv < 3)
    return hb_compile_fail(def, r->line, r->column, err,
                           "rod %s: %d vertices are too few; at least 3 are needed", r->name ? r->name : "?",
                           r->nv);
  if (!r->rest || !r->initial || !r->mass || !r->B || !r->beta)
    return hb_compile_fail(def, r->line, r->column, err,
                           "rod %s: rest shape, initial shape, mass, bending and twisting must all be given",
                           r->name ? r->name : "?");
  struct {
    const char *what;
    const double *a;
    int count, sign;
  } arrays[] = {
      {"rest shape", r->rest, 3 * r->nv, 0},         {"initial shape", r->initial, 3 * r->nv, 0},
      {"velocity", r->velocity, 3 * r->nv, 0},       {"mass", r->mass, r->nv, 2},
      {"bending", r->B, 3 * (r->nv - 1), 0},         {"twisting", r->beta, r->nv, 1},
      {"viscosity", r->viscosity, r->nv - 1, 1},     {"stretching", r->stretching, r->nv - 1, 2},
      {"natural twist", r->natural_twist, r->nv, 0}, {"rest directors", r->rest_m1, 3 * (r->nv - 1), 0},
      {"mass damping", &r->mass_damping, 1, 1},      {"radius", &r->radius, 1, 2},
      {"director", r->first_director, 3, 0}};
  hb_status status = HB_OK;
  for (size_t k = 0; !status && k < sizeof arrays / sizeof arrays[0]; k++)
    status = check_array(def, r, arrays[k].what, arrays[k].a, arrays[k].count, arrays[k].sign, err);
  if (!status) status = check_edges(def, r, "rest", r->rest, err);
  if (!status) status = check_edges(def, r, "initial", r->initial, err);
  if (!status) status = check_closed(def, r, err);
  if (!status) status = check_forms(def, r, err);
  if (!status) status = check_folds(def, r, err);
  return status;
}
