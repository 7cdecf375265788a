/* From the polygon of a simulation to a smooth tube.
 *
 * The centreline goes through the vertices as a cubic whose direction at a vertex is the mean of its edges,
 * weighted by the other edge's length; twenty-five vertices then look like a rod and not like a chain. */
#include "render/strand.h"

#include "base/memory.h"
#include "math/rotation.h"

/* Radians of turning, and of twist, in one piece at most; pixels between a piece and its arc at most. */
#define TURN_PER_PIECE 0.25
#define SAG_PER_PIECE 0.12
#define TWIST_PER_PIECE 0.25
/* Share of the picture that thin tubes may cover until they are drawn thinner; pixels of radius that are
 * drawn at least; share of the usual least radius below which a picture is a thicket. */
#define MOST_COVER 0.5
#define THINNEST 0.3
#define THICKET 0.5
/* Nodes that a picture may have beyond one per vertex. */
#define MOST_NODES 400000.0
enum { MOST_CUTS = 96 };

/* One tube being cut. */
typedef struct cutter {
  const hb_tube *tube;
  const hb_lens *lens;
  int index;
  double radius, thin; /* radius as drawn; 1 or less: cuts are thinned out */
  bool closed;         /* the last vertex is at the place of the first */
  bool thicket;
} cutter;

/* Is the place a finite number of a size that can be squared? */
static bool usable(const double *p) { return fabs(p[0]) < 1e100 && fabs(p[1]) < 1e100 && fabs(p[2]) < 1e100; }

/* Vertex i in camera space. */
static hb_v3 vertex(const cutter *c, int i) {
  return hb_lens_look(c->lens, hb_v3_load(c->tube->xyz + 3 * (size_t)i));
}

/* A direction of the scene in camera space. */
static hb_v3 turn(const hb_lens *lens, hb_v3 d) {
  return (hb_v3){hb_v3_dot(d, lens->right), hb_v3_dot(d, lens->down), hb_v3_dot(d, lens->forward)};
}

/* Unit tangent of edge j; zero where its vertices coincide. */
static hb_v3 edge_tangent(const cutter *c, int j) {
  return hb_v3_unit(hb_v3_sub(vertex(c, j + 1), vertex(c, j)));
}

/* Does a tube come back to where it began? */
static bool is_closed(const hb_tube *tube) {
  const double *a = tube->xyz, *b = tube->xyz + 3 * (size_t)(tube->nv > 0 ? tube->nv - 1 : 0);
  return tube->nv > 3 && a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/* Is the strand from .. to a closed tube as a whole? */
static bool around(const cutter *c, int from, int to) {
  return c->closed && from == 0 && to == c->tube->nv - 1;
}

/* Slope of the centreline, per length, at vertex i of the strand from .. to. */
static hb_v3 slope(const cutter *c, int i, int from, int to) {
  bool ring = around(c, from, to);
  if (to - from < 2) return edge_tangent(c, from);
  if (ring && i == to) i = from;
  if (!ring && (i == from || i == to)) { /* the end edge becomes a parabola */
    hb_v3 next = slope(c, i == from ? from + 1 : to - 1, from, to);
    hb_v3 edge = edge_tangent(c, i == from ? from : to - 1);
    return hb_v3_sub(hb_v3_scale(2, edge), next);
  }
  int before = ring && i == from ? to - 1 : i - 1;
  hb_v3 e = hb_v3_sub(vertex(c, i), vertex(c, before)), f = hb_v3_sub(vertex(c, i + 1), vertex(c, i));
  double a = hb_v3_norm(e), b = hb_v3_norm(f);
  if (!(a > 0) || !(b > 0)) return hb_v3_unit(hb_v3_add(e, f));
  return hb_v3_scale(1 / (a + b), hb_v3_add(hb_v3_scale(b / a, e), hb_v3_scale(a / b, f)));
}

/* First director of edge j in camera space; false where there is none. */
static bool director(const cutter *c, int j, hb_v3 *out) {
  if (!c->tube->m1 || !usable(c->tube->m1 + 3 * (size_t)j)) return false;
  hb_v3 m = turn(c->lens, hb_v3_load(c->tube->m1 + 3 * (size_t)j));
  double n = hb_v3_norm(m);
  if (!(n > 1e-6)) return false;
  *out = hb_v3_scale(1 / n, m);
  return true;
}

/* Pieces that edge j of the strand from .. to is cut into. */
static int cuts(const cutter *c, int j, int from, int to) {
  hb_v3 a = vertex(c, j), b = vertex(c, j + 1);
  double length = hb_v3_norm(hb_v3_sub(b, a));
  double wish = c->thicket ? 1 : length / (1.5 * c->radius);
  double bend = hb_v3_norm(hb_v3_sub(slope(c, j + 1, from, to), slope(c, j, from, to)));
  wish = fmax(wish, bend / TURN_PER_PIECE);
  wish = fmax(wish, sqrt(length / c->lens->pixel * bend / (8 * SAG_PER_PIECE)));
  hb_v3 m, n;
  if (!c->thicket && j > from && director(c, j - 1, &m) && director(c, j, &n))
    wish = fmax(wish, hb_v3_norm(hb_v3_sub(m, n)) / TWIST_PER_PIECE);
  double most = fmin(length / (2 * c->lens->pixel), MOST_CUTS);
  wish = fmin(wish, most) * c->thin;
  return wish > 1 ? (int)ceil(wish) : 1;
}

/* Between unit vectors a and b, a fraction f of the angle: halved four times, then straight. */
static hb_v3 between(hb_v3 a, hb_v3 b, double f) {
  for (int k = 0; k < 4; k++) {
    hb_v3 sum = hb_v3_add(a, b);
    if (!(hb_v3_norm(sum) > 1e-6)) return a;
    hb_v3 middle = hb_v3_unit(sum);
    f *= 2;
    if (f < 1)
      b = middle;
    else {
      a = middle;
      f -= 1;
    }
  }
  return hb_v3_unit(hb_v3_axpy(hb_v3_scale(1 - f, a), f, b));
}

/* First director at the fraction f of edge j, normal to t: that of the edge at its middle. */
static hb_v3 director_at(const cutter *c, int j, double f, hb_v3 t, int from, int to) {
  int other = f < 0.5 ? j - 1 : j + 1;
  if (around(c, from, to)) other = other < from ? to - 1 : other >= to ? from : other;
  hb_v3 m, n;
  if (!director(c, j, &m)) return (hb_v3){0, 0, 0};
  m = hb_project_normal(hb_transport(m, edge_tangent(c, j), t), t);
  if (other < from || other >= to || !director(c, other, &n)) return m;
  n = hb_project_normal(hb_transport(n, edge_tangent(c, other), t), t);
  return between(m, n, fabs(f - 0.5));
}

/* Point and direction at the fraction f of edge j. */
static void evaluate(const cutter *c, int j, double f, int from, int to, hb_node *node) {
  hb_v3 a = vertex(c, j), b = vertex(c, j + 1), chord = hb_v3_sub(b, a);
  double length = hb_v3_norm(chord), g = 1 - f;
  hb_v3 da = hb_v3_scale(length, slope(c, j, from, to)), db = hb_v3_scale(length, slope(c, j + 1, from, to));
  double s = f * f * (3 - 2 * f);
  node->p = hb_v3_axpy(a, s, chord);
  node->p = hb_v3_axpy(node->p, f * g * g, da);
  node->p = hb_v3_axpy(node->p, -f * f * g, db);
  hb_v3 t = hb_v3_scale(6 * f * g, chord);
  t = hb_v3_axpy(t, g * (1 - 3 * f), da);
  t = hb_v3_axpy(t, f * (3 * f - 2), db);
  double n = hb_v3_norm(t);
  node->t = n > 1e-9 * length && n > 0 ? hb_v3_scale(1 / n, t) : hb_v3_unit(chord);
}

/* Appends a node, unless it is too near to the last one to matter. */
static void append(hb_strands *s, hb_node node, double least) {
  if (!node.first) {
    hb_node *before = &s->node[s->count - 1];
    if (!node.last && hb_v3_norm(hb_v3_sub(node.p, before->p)) < least) return;
    if (!(hb_v3_norm(node.t) > 0.5)) node.t = before->t;
    node.u = hb_project_normal(hb_transport(before->u, before->t, node.t), node.t);
    node.arc = before->arc + hb_v3_norm(hb_v3_sub(node.p, before->p));
    node.strand = before->strand;
  } else {
    if (!(hb_v3_norm(node.t) > 0.5)) node.t = (hb_v3){1, 0, 0};
    node.u = hb_any_normal(node.t);
    node.strand = s->count;
  }
  s->node[s->count++] = node;
}

/* Cuts the vertices from .. to, all usable, into nodes. */
static void cut(const cutter *c, int from, int to, hb_strands *s) {
  double least = 0.6 * c->lens->pixel;
  for (int j = from; j < to; j++) {
    int pieces = cuts(c, j, from, to);
    for (int k = 0; k < pieces + (j == to - 1); k++) {
      hb_node node = {.tube = c->index, .first = j == from && k == 0, .last = j == to - 1 && k == pieces};
      double f = (double)k / pieces;
      evaluate(c, j, f, from, to, &node);
      if (!c->thicket) node.m = director_at(c, j, f, node.t, from, to);
      append(s, node, least);
    }
  }
}

/* The next stretch of usable vertices from *from on; false at the end of the tube. */
static bool next_strand(const hb_tube *tube, int *from, int *to) {
  int i = *from;
  for (;; i = *to + 1) {
    while (i < tube->nv && !usable(tube->xyz + 3 * (size_t)i)) i++;
    if (i >= tube->nv) return false;
    *from = *to = i;
    while (*to + 1 < tube->nv && usable(tube->xyz + 3 * (size_t)(*to + 1))) ++*to;
    if (*to > *from) return true;
  }
}

/* Colours as linear light. The stripe is amber on cold colours and ink on warm ones: both stand out against
 * the tube and against a light page. */
static void choose_colors(const hb_tube *tube, hb_look *look) {
  const double amber[3] = {0.90, 0.48, 0.13}, ink[3] = {0.016, 0.030, 0.070};
  for (int k = 0; k < 3; k++) {
    double v = tube->color[k];
    v = v > 0 ? fmin(v, 1) : 0;
    look->base[k] = v * v;
  }
  const double *stripe = look->base[0] > look->base[2] * 1.2 ? ink : amber;
  for (int k = 0; k < 3; k++) look->stripe[k] = stripe[k];
}

/* What cannot be seen is drawn thicker: the least radius of a single tube. */
static double least_radius(const hb_lens *lens) {
  return fmin(fmax(lens->rect.h / 200.0, 1), 1.75) * lens->pixel;
}

/* Radius as drawn. */
static double drawn_radius(double radius, double least) {
  return radius > least && radius < 1e100 ? radius : least;
}

/* Where all the tubes that are drawn thicker would cover more than MOST_COVER of the picture, their least
 * radius shrinks; it is the same for all frames of a film, since rods keep their lengths. */
static double crowded_radius(const hb_tube *tubes, int count, const hb_lens *lens) {
  double least = least_radius(lens), length = 0, pixels = (double)lens->rect.w * lens->rect.h;
  for (int i = 0; i < count; i++) {
    if (tubes[i].radius > least && tubes[i].radius < 1e100) continue;
    for (int from = 0, to = 0; next_strand(&tubes[i], &from, &to); from = to + 1)
      for (int j = from; j < to; j++) {
        const double *x = tubes[i].xyz + 3 * (size_t)j;
        length += hb_v3_norm(hb_v3_sub(hb_v3_load(x + 3), hb_v3_load(x)));
      }
  }
  double cover = 2 * least * length / (lens->pixel * lens->pixel * pixels);
  return cover > MOST_COVER ? fmax(least * MOST_COVER / cover, fmin(THINNEST * lens->pixel, least)) : least;
}

/* Box around all nodes, and the largest radius. */
static void measure(hb_strands *s) {
  s->lo = s->hi = s->count ? s->node[0].p : (hb_v3){0, 0, 0};
  for (int i = 0; i < s->count; i++) {
    hb_v3 p = s->node[i].p;
    s->lo = (hb_v3){fmin(s->lo.x, p.x), fmin(s->lo.y, p.y), fmin(s->lo.z, p.z)};
    s->hi = (hb_v3){fmax(s->hi.x, p.x), fmax(s->hi.y, p.y), fmax(s->hi.z, p.z)};
    s->radius = fmax(s->radius, s->look[s->node[i].tube].radius);
  }
  s->size = hb_v3_norm(hb_v3_sub(s->hi, s->lo)) + 2 * s->radius;
}

/* Goes over all tubes: cuts them into out, or only counts the nodes where out is NULL. */
static double walk(const hb_tube *tubes, int count, const hb_lens *lens, const cutter *how, hb_strands *out) {
  double total = 0;
  for (int i = 0; i < count; i++) {
    cutter c = {.tube = &tubes[i],
                .lens = lens,
                .index = i,
                .radius = drawn_radius(tubes[i].radius, how->radius),
                .thin = how->thin,
                .closed = is_closed(&tubes[i]),
                .thicket = how->thicket};
    for (int from = 0, to = 0; next_strand(&tubes[i], &from, &to); from = to + 1) {
      if (out)
        cut(&c, from, to, out);
      else
        for (int j = from; j < to; j++) total += cuts(&c, j, from, to) + (j == to - 1);
    }
  }
  return total;
}

/* Counts first, then cuts, so that there is one allocation. */
hb_status hb_strands_make(const hb_tube *tubes, int count, const hb_lens *lens, hb_strands *out,
                          hb_error *err) {
  *out = (hb_strands){0};
  cutter how = {.radius = crowded_radius(tubes, count, lens), .thin = 1};
  for (int i = 0; i < count; i++) out->radius = fmax(out->radius, drawn_radius(tubes[i].radius, how.radius));
  how.thicket = out->radius < THICKET * least_radius(lens);
  double total = walk(tubes, count, lens, &how, NULL);
  if (total > MOST_NODES) {
    how.thin = MOST_NODES / total;
    total = walk(tubes, count, lens, &how, NULL);
  }
  out->thicket = how.thicket;
  if (total > 1e9) return hb_fail(err, HB_ERR_INPUT, "the picture has more than 1e9 vertices");
  out->look = hb_alloc((size_t)(count > 0 ? count : 0), sizeof *out->look);
  out->node = hb_alloc((size_t)total, sizeof *out->node);
  if (!out->look || !out->node) {
    hb_strands_free(out);
    return hb_fail_memory(err, "tubes of a picture");
  }
  for (int i = 0; i < count; i++) {
    choose_colors(&tubes[i], &out->look[i]);
    out->look[i].radius = drawn_radius(tubes[i].radius, how.radius);
  }
  walk(tubes, count, lens, &how, out);
  measure(out);
  return HB_OK;
}

/* Frees the nodes. */
void hb_strands_free(hb_strands *strands) {
  hb_free(strands->node);
  hb_free(strands->look);
  *strands = (hb_strands){0};
}
