/* The lengths of a closed rod: cyclic tridiagonal, by elimination with a border (docs/theory, 12.5). Rows
 * 1 .. n-1 are a chain; each keeps a column for edge 0, whose row comes last. The vertex where the ends meet
 * stands in two slots with half its mass each: it moves by half of what one of them would. */
#include "rod/inextensible.h"
#include "solve/project_parts.h"

/* Share of the inverse mass of its slot that a vertex has (first and last slot: halves of one vertex). */
static double share_of(const hb_rod *rod, int i) { return i == 0 || i + 1 == rod->nv ? 0.5 : 1; }

/* a^T W b at vertex i of the rod. */
static double at_vertex(const hb_length_system *s, int i, hb_v3 a, hb_v3 b) {
  return share_of(s->rod, i) * hb_weighted(a, s->m->inv_mass + 3 * (s->rod->first + i), b);
}

/* Gradient of edge j, its right-hand side, and how far off its length is. */
static double look_at(const hb_length_system *s, int j, hb_length_finding *found) {
  int k = s->rod->first + j;
  double inv_rest = s->m->inv_rest_length[k];
  hb_v3 g;
  double C = hb_inextensible_edge(s->x + 3 * k, s->m->rest_length[k], inv_rest, &g);
  hb_v3_store(s->w->gradient + 3 * j, g);
  if (s->kind == HB_RIGHT_GIVEN) return s->w->right[j];
  if (s->kind == HB_RIGHT_RATES)
    return hb_v3_dot(g, hb_v3_sub(hb_v3_load(s->v + 3 * k + 3), hb_v3_load(s->v + 3 * k)));
  double size = fabs(C) * (s->relative ? inv_rest : 1);
  if (!(size <= found->worst)) { /* also true for not-a-number */
    found->worst = size;
    found->edge = k;
  }
  return C;
}

/* Direction in which edge j is corrected. */
static hb_v3 direction_of(const hb_length_system *s, int j) {
  return hb_v3_load((s->along ? s->w->direction : s->w->gradient) + 3 * j);
}

/* Entry of row j and column k, neighbours that share vertex i. */
static double between(const hb_length_system *s, int j, int k, int i) {
  return -at_vertex(s, i, hb_v3_load(s->w->gradient + 3 * j), direction_of(s, k));
}

/* Diagonal entry. */
static double diagonal_of(const hb_length_system *s, int j) {
  hb_v3 g = hb_v3_load(s->w->gradient + 3 * j), d = direction_of(s, j);
  return at_vertex(s, j, g, d) + at_vertex(s, j + 1, g, d);
}

/* 1/pivot, 0 where the row hangs on the others. */
static double invert(double pivot, double diagonal, hb_length_finding *found) {
  bool sound = fabs(pivot) > HB_LENGTH_SINGULAR * fabs(diagonal);
  found->full = found->full && sound;
  return sound ? 1 / pivot : 0;
}

/* Down the chain, edge 0, and up again. */
hb_length_finding hb_ring_solve(const hb_length_system *s) {
  hb_project_work *w = s->w;
  int n = s->rod->nv - 1;
  hb_length_finding found = {-1, s->rod->first, true};
  for (int j = 0; j < n; j++) w->right[j] = look_at(s, j, &found);
  double first = diagonal_of(s, 0), whole = first, row = 0; /* row: entry (0, j) as elimination leaves it */
  for (int j = 1; j < n; j++) {
    double diagonal = diagonal_of(s, j), pivot = diagonal, corner = 0;
    w->link[j] = j + 1 < n ? between(s, j, j + 1, j + 1) : 0;
    if (j == 1) {
      corner += between(s, 1, 0, 1);
      row = between(s, 0, 1, 1);
    }
    if (j == n - 1) {
      corner += between(s, j, 0, 0);
      row += between(s, 0, j, 0);
    }
    if (j > 1) {
      double ratio = between(s, j, j - 1, j) * w->pivot[j - 1];
      pivot -= ratio * w->link[j - 1];
      w->right[j] -= ratio * w->right[j - 1];
      corner -= ratio * w->corner[j - 1];
    }
    w->pivot[j] = invert(pivot, diagonal, &found);
    w->corner[j] = corner;
    double ratio = row * w->pivot[j];
    first -= ratio * corner;
    w->right[0] -= ratio * w->right[j];
    row = -ratio * w->link[j];
  }
  w->right[0] *= invert(first, whole, &found);
  for (int j = n - 1; j > 0; j--) {
    double next = j + 1 < n ? w->link[j] * w->right[j + 1] : 0;
    w->right[j] = (w->right[j] - next - w->corner[j] * w->right[0]) * w->pivot[j];
  }
  return found;
}

/* Vertex after vertex; the last slot gets what the first has, to the bit. */
double hb_ring_apply(const hb_model *m, const hb_rod *rod, const double *unknown, const hb_length_effect *e) {
  int n = rod->nv - 1, o = rod->first;
  hb_v3 pull = hb_v3_scale(unknown[n - 1], hb_v3_load(e->direction + 3 * (n - 1)));
  hb_v3 start = {0, 0, 0}, last = {0, 0, 0};
  double worst = 0;
  for (int i = 0; i < n; i++) {
    const double *mass = m->inv_mass + 3 * (o + i);
    double share = share_of(rod, i);
    hb_v3 next = hb_v3_scale(unknown[i], hb_v3_load(e->direction + 3 * i));
    hb_v3 moved = {-share * mass[0] * (pull.x - next.x), -share * mass[1] * (pull.y - next.y),
                   -share * mass[2] * (pull.z - next.z)};
    if (e->x) hb_v3_accumulate(e->x + 3 * (o + i), hb_v3_scale(e->x_part, moved));
    hb_v3_accumulate(e->v + 3 * (o + i), hb_v3_scale(e->v_part, moved));
    if (e->lambda) e->lambda[i] += unknown[i];
    if (i == 0) start = moved;
    for (int end = 0; e->judged && i > 0 && end <= (i == n - 1); end++) { /* the edge before, the last edge */
      hb_v3 change = end ? hb_v3_sub(start, moved) : hb_v3_sub(moved, last);
      double inv_rest = m->inv_rest_length[o + i - 1 + end];
      worst = fmax(worst, hb_v3_dot(change, change) * inv_rest * (e->relative ? inv_rest : 1));
    }
    pull = next;
    last = moved;
  }
  for (int c = 0; c < 3; c++) {
    if (e->x) e->x[3 * (o + n) + c] = e->x[3 * o + c];
    e->v[3 * (o + n) + c] = e->v[3 * o + c];
  }
  return worst;
}
