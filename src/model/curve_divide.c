/* Division of a curve into equal chords: a march over a polyline gives the start, Newton's method on all
 * chords at once the rest. */
#include "base/memory.h"
#include "math/solve1d.h"
#include "math/vec3.h"
#include "model/curve_parts.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Longest arc that an edge may stand for, in edges; a three-quarter circle has 3.3. */
#define CUT 3.5

/* A polyline with the arc length up to each of its points. */
typedef struct polyline {
  const double *points;
  const double *arc;
  int segments;
  int steps; /* chords to march */
} polyline;

/* Point k of the polyline. */
static hb_v3 node(const polyline *line, int k) { return hb_v3_load(line->points + 3 * (size_t)k); }

/* Distance of two points. */
static double separation(hb_v3 a, hb_v3 b) { return hb_v3_norm(hb_v3_sub(b, a)); }

/* Where the segment from a to b leaves the sphere of radius c about p, as a fraction; a is inside, b is not.
 */
static double exit_fraction(hb_v3 p, hb_v3 a, hb_v3 b, double c) {
  hb_v3 w = hb_v3_scale(1 / c, hb_v3_sub(a, p)), d = hb_v3_scale(1 / c, hb_v3_sub(b, a));
  double dd = hb_v3_dot(d, d), wd = hb_v3_dot(w, d), inside = 1 - hb_v3_dot(w, w);
  double root = sqrt(fmax(0, wd * wd + dd * inside));
  double f = wd > 0 ? inside / (wd + root) : (root - wd) / dd;
  return f > 0 ? (f < 1 ? f : 1) : 0;
}

/* Walks steps chords of length c along the line, each to the first place at that distance. Returns how far
 * behind the end the walk gets (the line goes on straight there), negative: how much arc is left. places (may
 * be NULL): segment number + fraction of every vertex. */
static double march(const polyline *line, double c, double *places) {
  int last = line->segments, k = 0;
  double f = 0;
  hb_v3 p = node(line, 0);
  if (places) places[0] = 0;
  for (int i = 1; i <= line->steps; i++) {
    int j = k + 1;
    while (j <= last && separation(p, node(line, j)) < c) j++;
    if (j > last) {
      hb_v3 end = node(line, last), w = hb_v3_sub(end, p),
            u = hb_v3_unit(hb_v3_sub(end, node(line, last - 1)));
      double along = hb_v3_dot(w, u), more = sqrt(fmax(0, along * along + c * c - hb_v3_dot(w, w))) - along;
      for (int r = i; places && r <= line->steps; r++) places[r] = last;
      return more + (line->steps - i) * c;
    }
    hb_v3 a = node(line, j - 1), b = node(line, j);
    if (j - 1 == k)
      f += c / separation(a, b);
    else
      f = exit_fraction(p, a, b, c);
    if (f > 1) f = 1;
    k = j - 1;
    p = hb_v3_axpy(a, f, hb_v3_sub(b, a));
    if (places) places[i] = k + f;
  }
  return -(line->arc[last] - line->arc[k] - f * (line->arc[k + 1] - line->arc[k]));
}

/* march as a function of c. */
static double overshoot(const void *context, double c) { return march(context, c, NULL); }

/* Places of the vertices on the line at equal arcs. */
static void even_places(const polyline *line, double *places) {
  double length = line->arc[line->segments];
  int k = 0;
  for (int i = 0; i <= line->steps; i++) {
    double arc = length * ((double)i / line->steps);
    while (k < line->segments - 1 && line->arc[k + 1] < arc) k++;
    double piece = line->arc[k + 1] - line->arc[k];
    places[i] = k + (piece > 0 ? fmin(1, fmax(0, (arc - line->arc[k]) / piece)) : 0);
  }
  places[line->steps] = line->segments;
}

/* Chord with which the march ends at the line's end; where the march jumps over the end (a corner comes into
 * reach), the place of the jump. */
static double march_chord(const polyline *line) {
  double length = line->arc[line->segments], c = length / line->steps;
  hb_bracket bracket = {c, overshoot(line, c), 0, -length};
  /* chords are shorter than arcs, so the march with arc/steps is never short, but for round-off */
  return bracket.fa > 0 ? hb_solve_bracketed(overshoot, line, bracket, 0) : c;
}

/* Places of the march: with a slightly shorter chord, a slightly longer one, or between these two. At a jump
 * the division lies between: a vertex behind a sharp corner, where the march finds the places before it and
 * far behind. */
static void march_places(const polyline *line, double c, double share, double *places, double *work) {
  const double nudge = 1e-9;
  march(line, c * (1 - nudge), places);
  march(line, c * (1 + nudge), work);
  for (int i = 0; i <= line->steps; i++) places[i] += share * (work[i] - places[i]);
  places[line->steps] = line->segments;
}

/* A division in the making. */
typedef struct division {
  const hb_path *path;
  int steps;
  double *p;        /* steps + 1 parameters */
  double *trial;    /* steps + 1, the next ones */
  double *constant; /* change of a parameter when the chord is kept ... */
  double *slope;    /* ... and per change of the chord */
} division;

/* Mean chord and largest deviation from it for the given parameters; writes the vertices. */
static double deviation(const division *d, const double *p, double *xyz, double *mean) {
  double slope[3], sum = 0, worst = 0;
  for (int i = 0; i <= d->steps; i++) d->path->at(d->path->context, p[i], xyz + 3 * (size_t)i, slope);
  for (int i = 0; i < d->steps; i++)
    sum += separation(hb_v3_load(xyz + 3 * (size_t)i), hb_v3_load(xyz + 3 * (size_t)i + 3));
  *mean = sum / d->steps;
  for (int i = 0; i < d->steps; i++) {
    double c = separation(hb_v3_load(xyz + 3 * (size_t)i), hb_v3_load(xyz + 3 * (size_t)i + 3));
    worst = fmax(worst, fabs(c - *mean));
  }
  return isfinite(worst) ? worst : HUGE_VAL;
}

/* Newton correction of all parameters. The chord conditions form a chain, so that each correction follows
 * from the one before as constant + slope * (change of the chord); the end, which stays, gives the change of
 * the chord. */
static bool correct(const division *d, const double *xyz, double mean) {
  double position[3], here[3], next[3];
  d->path->at(d->path->context, d->p[0], position, here);
  d->constant[0] = d->slope[0] = 0;
  for (int i = 0; i < d->steps; i++) {
    hb_v3 chord = hb_v3_sub(hb_v3_load(xyz + 3 * (size_t)i + 3), hb_v3_load(xyz + 3 * (size_t)i));
    double c = hb_v3_norm(chord);
    d->path->at(d->path->context, d->p[i + 1], position, next);
    double ahead = hb_v3_dot(chord, hb_v3_load(next)) / c, behind = hb_v3_dot(chord, hb_v3_load(here)) / c;
    d->constant[i + 1] = (mean - c + behind * d->constant[i]) / ahead;
    d->slope[i + 1] = (1 + behind * d->slope[i]) / ahead;
    memcpy(here, next, sizeof here);
  }
  double change = -d->constant[d->steps] / d->slope[d->steps];
  for (int i = 1; i < d->steps; i++) d->constant[i] += d->slope[i] * change;
  d->constant[d->steps] = 0;
  return isfinite(change);
}

/* p + scale * correction, false if the order of the vertices along the curve would change. */
static bool try_step(const division *d, double scale) {
  d->trial[0] = d->p[0];
  for (int i = 1; i <= d->steps; i++) {
    d->trial[i] = d->p[i] + scale * d->constant[i];
    if (!(d->trial[i] > d->trial[i - 1])) return false;
  }
  return true;
}

/* Arc length of the sampled path up to parameter p. */
static double arc_at(const hb_path *path, const polyline *line, double p) {
  double place = (p - path->from) / (path->to - path->from) * line->segments;
  int k = place < 1 ? 0 : place > line->segments - 1 ? line->segments - 1 : (int)place;
  return line->arc[k] + (place - k) * (line->arc[k + 1] - line->arc[k]);
}

/* HB_ERR_INPUT if an edge takes a short cut: its arc is CUT times its chord or more. A hairpin that the edges
 * are too long for has no other division. */
static hb_status check_cuts(const division *d, const polyline *line, double chord, hb_error *err) {
  for (int i = 0; i < d->steps; i++) {
    double arc = arc_at(d->path, line, d->p[i + 1]) - arc_at(d->path, line, d->p[i]);
    if (arc > CUT * chord)
      return hb_fail(
          err, HB_ERR_INPUT,
          "%d equal edges are too few for the curve: edge %d would cut off a bend that is %.3g times as "
          "long as the edge; use more vertices",
          d->steps, i, arc / chord);
  }
  return HB_OK;
}

/* Newton until the chords do not get more equal; shorter steps where a full one makes it worse. Returns the
 * deviation that is left; the vertices are in xyz. */
static double equalise(division *d, double *xyz, double *mean) {
  double error = deviation(d, d->p, xyz, mean);
  size_t bytes = ((size_t)d->steps + 1) * sizeof *d->p;
  for (int round = 0; round < 60 && error > 0; round++) {
    if (!correct(d, xyz, *mean)) break;
    bool better = false;
    for (double scale = 1; !better && scale > 1e-3; scale /= 2) {
      if (!try_step(d, scale)) continue;
      double next = deviation(d, d->trial, xyz, mean);
      better = next < error;
      if (better) error = next;
    }
    if (!better) break;
    memcpy(d->p, d->trial, bytes);
  }
  return deviation(d, d->p, xyz, mean);
}

/* Points of the path at even parameters, and the arc length up to them. */
static void sample(const hb_path *path, int samples, double *points, double *arc) {
  double slope[3];
  for (int k = 0; k < samples; k++) {
    double f = (double)k / (samples - 1),
           p = k == samples - 1 ? path->to : path->from + f * (path->to - path->from);
    path->at(path->context, p, points + 3 * (size_t)k, slope);
    arc[k] = 0;
    if (k > 0)
      arc[k] =
          arc[k - 1] + separation(hb_v3_load(points + 3 * (size_t)k - 3), hb_v3_load(points + 3 * (size_t)k));
  }
}

/* Places on the sampled line to parameters of the path. */
static void to_parameters(const polyline *line, division *d) {
  double width = d->path->to - d->path->from;
  for (int i = 0; i < d->steps; i++) d->p[i] = d->path->from + width * (d->p[i] / line->segments);
  d->p[d->steps] = d->path->to;
}

/* What round-off of the places and of the coordinates lets the chords differ by. */
static double round_off(const division *d, const polyline *line, const double *xyz, double mean) {
  double size = 0;
  for (size_t i = 0; i < 3 * ((size_t)d->steps + 1); i++) size = fmax(size, fabs(xyz[i]));
  return 1e-13 * mean + 8 * DBL_EPSILON * (size + line->arc[line->segments]);
}

/* Starts from different places until Newton equalises the chords to round-off: equal arcs if their chords are
 * equal already (so that a polyline with equal edges stays as it is), the march, equal arcs. Returns what is
 * left of the difference, over the chord; 0 if that is round-off. */
static double attempt_all(division *d, const polyline *line, double *xyz, double *mean) {
  static const double shares[] = {0.5, 0, 1, 0.25, 0.75};
  double least = HUGE_VAL, c = 0;
  for (int attempt = 0; attempt < 7; attempt++) {
    bool even = attempt == 0 || attempt == 6;
    if (attempt == 1) c = march_chord(line);
    if (even)
      even_places(line, d->p);
    else
      march_places(line, c, shares[attempt - 1], d->p, d->trial);
    to_parameters(line, d);
    double error = attempt == 0 ? deviation(d, d->p, xyz, mean) : equalise(d, xyz, mean);
    double allowed = round_off(d, line, xyz, *mean);
    if (attempt == 0 && error <= allowed) error = equalise(d, xyz, mean);
    if (*mean > 0 && error <= allowed) return 0;
    if (*mean > 0) least = fmin(least, error / *mean);
  }
  return least;
}

/* All attempts, then the verdict. work: 4 (steps + 1) doubles. */
static hb_status divide(const hb_path *path, const polyline *line, double *work, double *xyz, hb_error *err) {
  size_t n = (size_t)line->steps + 1;
  division d = {path, line->steps, work, work + n, work + 2 * n, work + 3 * n};
  double mean = 0, error = attempt_all(&d, line, xyz, &mean);
  if (error > 0)
    return hb_fail(
        err, HB_ERR_INPUT,
        "the curve cannot be divided into %d equal edges (they differ by %.2g of their length); it bends too "
        "sharply for so few, use more vertices",
        line->steps, error);
  hb_status status = check_cuts(&d, line, mean, err);
  return status == HB_OK ? hb_curve_check_edges(xyz, line->steps + 1, err) : status;
}

/* Memory around the work. */
hb_status hb_path_divide(const hb_path *path, int samples, int count, double *xyz, hb_error *err) {
  hb_status status = hb_curve_check_count(count, 2, err);
  if (status != HB_OK) return status;
  size_t m = (size_t)samples, n = (size_t)count;
  double *points = hb_alloc(4 * m, sizeof *points), *work = hb_alloc(4 * n, sizeof *work);
  if (!points || !work) {
    status = hb_fail_memory(err, "dividing a curve into equal edges");
  } else {
    polyline line = {points, points + 3 * m, samples - 1, count - 1};
    sample(path, samples, points, points + 3 * m);
    double length = line.arc[samples - 1];
    if (!isfinite(length))
      status = hb_fail(err, HB_ERR_INPUT, "the curve has points that are not finite");
    else if (!(length > 0))
      status = hb_fail(err, HB_ERR_INPUT, "the curve has no length: all its points coincide");
    else
      status = divide(path, &line, work, xyz, err);
  }
  hb_free(points);
  hb_free(work);
  return status;
}
