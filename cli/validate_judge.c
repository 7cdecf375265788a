/* Found against expected: errors, orders of convergence, limits. */
#include "base/memory.h"
#include "cli/validate.h"

#include <math.h>
#include <string.h>

/* The points of a case stand one behind the other. */
const cli_point *cli_case_points(const cli_validation *v, const cli_case *c) {
  for (int k = 0; k < v->point_count; k++)
    if (v->points[k].of == c) return &v->points[k];
  return NULL;
}

/* "P = 3, Q = 1" from the column of vary, as it is written: parameters of the scene, or the first setting if
 * none of them is one. */
void cli_case_label(const cli_case *c, int variant, char *text, size_t size) {
  text[0] = 0;
  for (int k = 0; c->vary && k < c->vary->count; k++) {
    size_t used = strlen(text);
    if (strpbrk(c->vary->children[k]->key, ".[") && (k > 0 || c->vary->count > 1)) continue;
    snprintf(text + used, size - used, "%s%s = %s", used ? ", " : "", c->vary->children[k]->key,
             c->vary->children[k]->children[variant]->text);
  }
}

/* A value of a verdict: where it is found, what it should be, in the points of one column. */
typedef struct column {
  const cli_point *points; /* by mesh */
  const cli_point *first;  /* of the case, for `same` */
  int index;               /* of the expectation */
} column;

/* What is expected at a mesh. */
static double expected(const column *k, const cli_expect *e, int mesh) {
  return e->same ? k->first->found[k->index] : k->points[mesh].expected[k->index];
}

/* Error at a mesh, relative where the tolerance is. */
static double error_at(const column *k, const cli_expect *e, int mesh) {
  double known = expected(k, e, mesh), error = k->points[mesh].found[k->index] - known;
  return e->within > 0 ? error / fabs(known) : error;
}

/* Order between the two finest meshes and the value that the errors of this order lead to. */
static void judge_order(cli_verdict *v, const column *k) {
  const cli_expect *e = v->expect;
  int last = v->of->mesh_count - 1;
  const cli_point *coarse = &k->points[last - 1], *fine = &k->points[last];
  double ratio = coarse->size / fine->size, a = error_at(k, e, last - 1), b = error_at(k, e, last);
  v->order = a / b > 0 ? log(a / b) / log(ratio) : (double)NAN;
  if (!(fabs(v->order - e->order) <= e->order_within)) {
    v->good = false;
    if (!v->why) v->why = "the order of convergence is another one";
  }
  if (e->limit <= 0) return;
  double f = fine->found[k->index], g = coarse->found[k->index], known = expected(k, e, last);
  v->limit_error = (f + (f - g) / (pow(ratio, e->order) - 1)) / known - 1;
  v->share = fmax(v->share, fabs(v->limit_error) / e->limit);
  if (!(fabs(v->limit_error) <= e->limit)) {
    v->good = false;
    if (!v->why) v->why = "the value on ever finer meshes is another one";
  }
}

/* One verdict over all meshes of a column. */
static void judge(cli_verdict *v, const column *k) {
  const cli_expect *e = v->expect;
  int meshes = v->of->mesh_count, from = e->kind == CLI_EXACT ? 0 : meshes - 1;
  v->relative = e->within > 0;
  v->tolerance = v->relative ? e->within : e->absolute;
  v->order = v->limit_error = (double)NAN;
  v->good = true;
  v->share = -1;
  for (int m = 0; m < meshes; m++)
    if (k->points[m].err.status || (e->same && k->first->err.status)) {
      v->good = false;
      v->why = "";
      v->found = v->expected = v->error = (double)NAN;
      return;
    }
  for (int m = from; m < meshes; m++) {
    double error = error_at(k, e, m), share = fabs(error) / v->tolerance;
    if (!(share <= v->share)) { /* also where it is no number */
      v->share = share;
      v->error = error;
      v->found = k->points[m].found[k->index];
      v->expected = expected(k, e, m);
    }
    if (share <= 1) continue;
    v->good = false;
    v->why = "the error is larger than the tolerance";
  }
  if (e->order > 0) judge_order(v, k);
}

/* All expectations at all columns of all cases. */
hb_status cli_validation_judge(cli_validation *v, hb_error *err) {
  size_t count = 0;
  for (int k = 0; k < v->case_count; k++)
    if (v->cases[k]->deed != CLI_NOT_YET)
      count += (size_t)v->cases[k]->variants * (size_t)v->cases[k]->expect_count;
  v->verdicts = hb_alloc(count, sizeof *v->verdicts);
  if (!v->verdicts) return hb_fail_memory(err, "verdicts");
  for (int k = 0; k < v->case_count; k++) {
    const cli_case *c = v->cases[k];
    const cli_point *points = cli_case_points(v, c);
    if (c->deed == CLI_NOT_YET || !points) continue;
    for (int variant = 0; variant < c->variants; variant++)
      for (int i = 0; i < c->expect_count; i++) {
        column col = {.points = points + variant * c->mesh_count, .first = points, .index = i};
        cli_verdict *verdict = &v->verdicts[v->verdict_count++];
        *verdict = (cli_verdict){.of = c, .expect = &c->expects[i], .variant = variant};
        judge(verdict, &col);
      }
  }
  return HB_OK;
}

/* All of its verdicts. */
bool cli_case_holds(const cli_validation *v, const cli_case *c) {
  for (int k = 0; k < v->verdict_count; k++)
    if (v->verdicts[k].of == c && !v->verdicts[k].good) return false;
  return true;
}
