/* Boundary conditions: which coordinates and frames are prescribed, and the spans of twist between them. */
#include "model/compile.h"

#include "base/memory.h"
#include "math/rotation.h"

/* Where support k of rod r stands: sentence prefix for messages. */
static hb_status support_fail(const hb_model *m, int r, const hb_support_def *s, hb_error *err,
                              const char *what) {
  return hb_compile_fail(m->def, s->line, s->column, err, "rod %s: support at index %d: %s", m->rods[r].name,
                         s->index, what);
}

/* Slot of the support's vertex or edge; negative indices count from the end. */
static hb_status resolve(const hb_model *m, int r, const hb_support_def *s, int *slot, hb_error *err) {
  int n = s->kind == HB_SUPPORT_POSITION ? m->rods[r].nv : m->rods[r].nv - 1;
  int index = s->index < 0 ? s->index + n : s->index;
  if (index < 0 || index >= n)
    return hb_compile_fail(m->def, s->line, s->column, err,
                           "rod %s: there is no %s %d; they count from 0 to %d", m->rods[r].name,
                           s->kind == HB_SUPPORT_POSITION ? "vertex" : "edge", s->index, n - 1);
  *slot = m->rods[r].first + index;
  return HB_OK;
}

/* Value of a support's formula at time 0, with the initial place as x, y, z. */
static double value_at_start(const hb_formula *f, const double place[3]) {
  double vars[HB_VAR_COUNT] = {0};
  for (int c = 0; c < 3; c++) vars[HB_VAR_X + c] = place[c];
  return hb_formula_eval(f, vars);
}

/* The other slot of the vertex where a closed rod's ends meet, or -1: this slot is another vertex. */
static int twin_of(const hb_rod *rod, int slot) {
  int last = rod->first + rod->nv - 1;
  if (!rod->closed || (slot != rod->first && slot != last)) return -1;
  return slot == last ? rod->first : last;
}

/* A prescribed vertex; twin: the other half of one where a closed rod's ends meet. */
static hb_status add_position(hb_model *m, int r, const hb_support_def *s, bool twin, hb_error *err) {
  hb_position_support *p = &m->positions[m->position_count];
  *p = (hb_position_support){.def = s, .base = -1, .edge = -1};
  hb_status status = resolve(m, r, s, &p->slot, err);
  if (status) return status;
  int other = twin_of(&m->rods[r], p->slot);
  if (twin) p->slot = other;
  double *x = &m->initial[3 * p->slot];
  for (int c = 0; c < 3; c++) {
    p->initial[c] = x[c];
    p->fixed[c] = !s->axis_free[c] && (s->held || s->value[c]);
  }
  for (int c = 0; c < 3; c++) {
    if (!p->fixed[c]) continue;
    if (m->inv_mass[3 * p->slot + c] == 0)
      return support_fail(m, r, s, err, "this coordinate is prescribed twice");
    m->inv_mass[3 * p->slot + c] = 0;
    if (s->value[c]) x[c] = value_at_start(s->value[c], p->initial);
    if (!isfinite(x[c])) return support_fail(m, r, s, err, "the prescribed position at time 0 is not finite");
  }
  m->position_count++;
  return other >= 0 && !twin ? add_position(m, r, s, true, err) : HB_OK;
}

/* A prescribed tangent: the far vertex of the edge is carried by the base vertex. */
static hb_status add_tangent(hb_model *m, int r, const hb_support_def *s, hb_error *err) {
  hb_position_support *p = &m->positions[m->position_count];
  *p = (hb_position_support){.def = s, .tangent = true};
  hb_status status = resolve(m, r, s, &p->edge, err);
  if (status) return status;
  p->base = s->base_is_end ? p->edge + 1 : p->edge;
  p->slot = s->base_is_end ? p->edge : p->edge + 1;
  p->sign = s->base_is_end ? -1 : 1;
  if (twin_of(&m->rods[r], p->slot) >= 0)
    return support_fail(
        m, r, s, err,
        "the vertex that this tangent would carry is the one where the closed rod's ends meet; "
        "another edge is expected");
  hb_v3 direction = hb_v3_sub(hb_v3_load(&m->initial[3 * p->edge + 3]), hb_v3_load(&m->initial[3 * p->edge]));
  const double *place = &m->initial[3 * p->base];
  if (!s->held)
    direction = (hb_v3){value_at_start(s->value[0], place), value_at_start(s->value[1], place),
                        value_at_start(s->value[2], place)};
  if (!(hb_v3_norm(direction) > 0))
    return support_fail(m, r, s, err, "the prescribed tangent at time 0 is zero");
  direction = hb_v3_unit(direction);
  int outermost = m->rods[r].first + (s->base_is_end ? m->rods[r].nv - 2 : 0);
  if (s->wall && (m->rods[r].closed || p->edge != outermost))
    return support_fail(m, r, s, err,
                        "only the first and the last edge can be clamped at their outer vertex");
  if (s->wall && s->held) direction = hb_compile_wall(m, r, s, direction);
  hb_v3_store(p->initial, direction);
  for (int c = 0; c < 3; c++) {
    if (m->inv_mass[3 * p->base + c] != 0)
      return support_fail(m, r, s, err,
                          "a prescribed tangent needs its base vertex prescribed in x, y and z");
    if (m->inv_mass[3 * p->slot + c] == 0)
      return support_fail(m, r, s, err, "this vertex is prescribed twice");
    m->inv_mass[3 * p->slot + c] = 0;
    p->fixed[c] = true;
  }
  hb_v3 end = hb_v3_axpy(hb_v3_load(place), p->sign * m->rest_length[p->edge], direction);
  hb_v3_store(&m->initial[3 * p->slot], end);
  m->position_count++;
  return HB_OK;
}

/* A prescribed frame, put in order of edges. */
static hb_status add_frame(hb_model *m, int r, const hb_support_def *s, hb_error *err) {
  hb_frame_support f = {.def = s};
  hb_status status = resolve(m, r, s, &f.slot, err);
  if (status) return status;
  int at = m->frame_count;
  while (at > m->rods[r].first_frame && m->frames[at - 1].slot >= f.slot) {
    if (m->frames[at - 1].slot == f.slot)
      return support_fail(m, r, s, err, "the material frame of this edge is prescribed twice");
    m->frames[at] = m->frames[at - 1];
    at--;
  }
  m->frames[at] = f;
  m->frame_count++;
  return HB_OK;
}

/* One span from edge slot a to b; panels if it can carry twist in closed form. */
static void add_span(hb_model *m, hb_rod *rod, int a, int b, int frame_a, int frame_b) {
  hb_span *s = &m->spans[m->span_count++];
  *s = (hb_span){.rod = rod->index,
                 .first_edge = a,
                 .last_edge = b,
                 .first_frame = frame_a,
                 .last_frame = frame_b,
                 .first_panel = m->panel_count};
  bool carries = rod->closed_form && (rod->closed || (frame_a >= 0 && frame_b >= 0));
  for (int i = a + 1; i <= b; i++) {
    carries = carries && m->beta[i] > 0;
    s->compliance += m->beta[i] > 0 ? m->voronoi[i] / (2 * m->beta[i]) : 0;
    s->natural_twist += m->rest_twist[i];
  }
  for (int from = a; carries && from < b; from += HB_PANEL_EDGES)
    m->panels[m->panel_count++] =
        (hb_panel){.from = from, .to = from + HB_PANEL_EDGES < b ? from + HB_PANEL_EDGES : b};
  s->panel_count = m->panel_count - s->first_panel;
}

/* Spans of one rod between its prescribed frames and its ends. */
static void make_spans(hb_model *m, hb_rod *rod) {
  int last = rod->first + rod->last_joint, at = rod->first, frame = -1;
  rod->first_span = m->span_count;
  for (int k = rod->first_frame; k < rod->first_frame + rod->frame_count; k++) {
    int edge = m->frames[k].slot;
    m->frame_of[edge] = k;
    if (edge > at) add_span(m, rod, at, edge, frame, k);
    at = edge;
    frame = k;
  }
  if (at < last || frame < 0) add_span(m, rod, at, last, frame, -1);
  rod->span_count = m->span_count - rod->first_span;
  rod->twist_free = rod->closed_form;
  for (int k = rod->first_span; k < m->span_count; k++)
    if (m->spans[k].panel_count > 0) rod->twist_free = false;
}

/* True if all three coordinates of a vertex are prescribed. */
static bool pinned(const hb_model *m, int slot) {
  return m->inv_mass[3 * slot] == 0 && m->inv_mass[3 * slot + 1] == 0 && m->inv_mass[3 * slot + 2] == 0;
}

/* True if any coordinate of a vertex is prescribed. */
static bool held_somehow(const hb_model *m, int slot) {
  return m->inv_mass[3 * slot] == 0 || m->inv_mass[3 * slot + 1] == 0 || m->inv_mass[3 * slot + 2] == 0;
}

/* True if the initial shape is longer between two vertices than the rest shape: taking its lengths would
 * help. */
static bool initial_is_longer(const hb_model *m, const hb_rod *rod, int a, int b) {
  const double *x = m->def->rods[rod->index].initial + 3 * (a - rod->first);
  double length = 0;
  for (int k = a; k < b; k++, x += 3) length += hb_v3_norm(hb_v3_sub(hb_v3_load(x + 3), hb_v3_load(x)));
  return length > m->arc[b] - m->arc[a];
}

/* The rod between neighbouring prescribed vertices a and b must reach. */
static hb_status check_reach(hb_model *m, const hb_rod *rod, int a, int b, hb_error *err) {
  double length = m->arc[b] - m->arc[a];
  double square = 0;
  for (int c = 0; c < 3; c++) /* only what both hold keeps them apart */
    if (m->inv_mass[3 * a + c] == 0 && m->inv_mass[3 * b + c] == 0)
      square +=
          (m->initial[3 * b + c] - m->initial[3 * a + c]) * (m->initial[3 * b + c] - m->initial[3 * a + c]);
  bool whole = pinned(m, a) && pinned(m, b);
  double distance = sqrt(square);
  double slack = 1e-9 * length;
  int i = a - rod->first, k = b - rod->first;
  const hb_rod_def *def = &m->def->rods[rod->index];
  if (b == a + 1 && whole && fabs(distance - length) > 1e-7 * length)
    return hb_compile_fail(
        m->def, def->line, def->column, err,
        "rod %s: vertices %d and %d are both prescribed, %.9g apart, but edge %d is %.9g long", rod->name, i,
        k, distance, i, length);
  if (distance > length + slack)
    return hb_compile_fail(
        m->def, def->line, def->column, err,
        "rod %s: vertices %d and %d are prescribed %.9g apart, but the rod between them is only "
        "%.9g long%s",
        rod->name, i, k, distance, length,
        initial_is_longer(m, rod, a, b) ? "; if the lengths of the initial shape are meant instead of "
                                          "those of the rest shape, set lengths: initial"
                                        : "");
  if (b > a + 1 && distance > length - slack)
    return hb_compile_note(
        m, err,
        "rod %s: the constraints leave no room: vertices %d and %d are prescribed as far apart as the "
        "rod between them is long (%.9g), so an inextensible rod can only lie straight and still "
        "there; what moves is what the length tolerance lets stretch",
        rod->name, i, k, length);
  return HB_OK;
}

/* Reach between all neighbouring prescribed vertices of a rod. */
static hb_status check_room(hb_model *m, const hb_rod *rod, hb_error *err) {
  int last = -1;
  for (int k = rod->first; !rod->extensible && k < rod->first + rod->nv; k++) {
    if (!held_somehow(m, k)) continue;
    hb_status status = last >= 0 ? check_reach(m, rod, last, k, err) : HB_OK;
    if (status) return status;
    last = k;
  }
  return HB_OK;
}

/* Supports of one rod: positions first, then tangents that hang on them, then frames. */
static hb_status compile_rod(hb_model *m, int r, hb_error *err) {
  const hb_rod_def *def = &m->def->rods[r];
  hb_rod *rod = &m->rods[r];
  hb_status status = HB_OK;
  rod->first_position = m->position_count;
  rod->first_frame = m->frame_count;
  for (int k = 0; !status && k < def->support_count; k++)
    if (def->supports[k].kind == HB_SUPPORT_POSITION)
      status = add_position(m, r, &def->supports[k], false, err);
  for (int k = 0; !status && k < def->support_count; k++)
    if (def->supports[k].kind == HB_SUPPORT_TANGENT) status = add_tangent(m, r, &def->supports[k], err);
  for (int k = 0; !status && k < def->support_count; k++)
    if (def->supports[k].kind == HB_SUPPORT_ANGLE || def->supports[k].kind == HB_SUPPORT_DIRECTOR)
      status = add_frame(m, r, &def->supports[k], err);
  rod->position_count = m->position_count - rod->first_position;
  rod->frame_count = m->frame_count - rod->first_frame;
  if (status) return status;
  make_spans(m, rod);
  return check_room(m, rod, err);
}

/* Tables big enough for all supports, then rod by rod. */
hb_status hb_compile_supports(hb_model *m, hb_error *err) {
  size_t supports = 0, spans = 0, panels = 0;
  for (int r = 0; r < m->rod_count; r++) {
    size_t own = (size_t)m->def->rods[r].support_count;
    supports += own;
    spans += own + 1;
    panels += own + 1 + (size_t)(m->rods[r].nv / HB_PANEL_EDGES);
  }
  m->positions = hb_alloc(2 * supports, sizeof *m->positions);
  m->frames = hb_alloc(supports, sizeof *m->frames);
  m->spans = hb_alloc(spans, sizeof *m->spans);
  m->panels = hb_alloc(panels, sizeof *m->panels);
  if (!m->positions || !m->frames || !m->spans || !m->panels) return hb_fail_memory(err, "supports");
  for (int k = 0; k < m->nv; k++) m->frame_of[k] = -1;
  hb_status status = HB_OK;
  for (int r = 0; !status && r < m->rod_count; r++) status = compile_rod(m, r, err);
  return status;
}
