/* The panels of `hebra plot`. */
#include "cli/chart.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>

/* Points of a curve at most; more cannot be told apart. */
enum { MOST_POINTS = 6000, MOST_SUPPORTS = 6 };

static const char *const colors[] = {"#26708a", "#c95a45", "#5c549e", "#d99e38",
                                     "#4f8050", "#944a73", "#5494ad", "#8c6647"};
enum { COLORS = sizeof colors / sizeof colors[0] };

/* Sends the buffer. */
void cli_chart_flush(cli_chart *c) {
  if (c->status == HB_OK && c->filled > 0) c->status = cli_pipe_write(&c->pipe, c->buffer, c->filled, c->err);
  c->filled = 0;
}

/* Formatted text; one call gives less than a kilobyte. */
void cli_chart_say(cli_chart *c, const char *format, ...) {
  if (c->filled + 2048 > sizeof c->buffer) cli_chart_flush(c);
  va_list args;
  va_start(args, format);
  int length = vsnprintf(c->buffer + c->filled, 2048, format, args);
  va_end(args);
  if (length > 0) c->filled += (size_t)(length < 2048 ? length : 2047);
}

/* Steps between the frames that are drawn. */
static long stride(const cli_chart *c) { return c->info->frames / MOST_POINTS + 1; }

/* Next frame of a curve over time: the last one always belongs to it; `frames` at the end. */
static long next_frame(const cli_chart *c, long k) {
  long frames = c->info->frames, next = k + stride(c);
  return k < frames - 1 && next > frames - 1 ? frames - 1 : next;
}

/* A data block of a series over time. floor_at: smaller absolute values are drawn there (for logarithms); 0:
 * none. */
static bool send_series(cli_chart *c, const char *name, double floor_at) {
  if (c->status == HB_OK) c->status = hb_reader_series(c->reader, name, c->series, c->err);
  if (c->status != HB_OK) return false;
  cli_chart_say(c, "$%s << EOD\n", name);
  for (long k = 0; k < c->info->frames; k = next_frame(c, k)) {
    double v = floor_at > 0 ? fmax(fabs(c->series[k]), floor_at) : c->series[k];
    cli_chart_say(c, "%.9g %.9g\n", c->times[k], v);
  }
  cli_chart_say(c, "EOD\n");
  return true;
}

/* Starts a panel over time. */
static void begin_time(cli_chart *c, const char *title, const char *unit) {
  cli_chart_say(c, "set title '%s'\nset xlabel 'time'\nset ylabel '%s'\n", title, unit);
}

/* One curve of a plot command. */
static void curve(cli_chart *c, int index, const char *data, const char *key, const char *style) {
  cli_chart_say(c, "%s $%s using 1:2 with lines lw 2 lc rgb '%s' %s title '%s'", index ? "," : "plot", data,
                colors[index % COLORS], style, key);
}

/* Kinetic, bending, twisting, and how well they balance. */
static void draw_energies(cli_chart *c) {
  const char *const names[] = {"kinetic", "bending", "twisting", "balance"};
  const char *const keys[] = {"kinetic", "bending", "twisting", "error of the balance"};
  for (int k = 0; k < 4; k++)
    if (!send_series(c, names[k], 0)) return;
  begin_time(c, "Energies", "energy");
  for (int k = 0; k < 4; k++) curve(c, k, names[k], keys[k], k == 3 ? "dt 2" : "");
  cli_chart_say(c, "\n");
}

/* The energy balance alone, with what goes in and out. */
static void draw_balance(cli_chart *c) {
  const char *const names[] = {"work_loads", "work_supports", "dissipated", "balance"};
  const char *const keys[] = {"work of the loads", "work of the supports", "dissipated",
                              "error of the balance"};
  for (int k = 0; k < 4; k++)
    if (!send_series(c, names[k], 0)) return;
  begin_time(c, "Energy balance", "energy");
  for (int k = 0; k < 4; k++) curve(c, k, names[k], keys[k], k == 3 ? "dt 2" : "");
  cli_chart_say(c, "\n");
}

/* Relative length errors, logarithmic. */
static void draw_length(cli_chart *c) {
  if (!send_series(c, "length_error", 1e-17) || !send_series(c, "worst_length_error", 1e-17)) return;
  begin_time(c, "Length error", "relative error of the edge lengths");
  cli_chart_say(c, "set logscale y\n");
  curve(c, 0, "length_error", "at the frame", "");
  curve(c, 1, "worst_length_error", "largest so far", "dt 2");
  cli_chart_say(c, "\nunset logscale y\n");
}

/* Three components. */
static void draw_vector(cli_chart *c, const char *name, const char *title, const char *unit) {
  char part[64];
  for (int k = 0; k < 3; k++) {
    snprintf(part, sizeof part, "%s_%c", name, "xyz"[k]);
    if (!send_series(c, part, 0)) return;
  }
  begin_time(c, title, unit);
  for (int k = 0; k < 3; k++) {
    const char key[2] = {"xyz"[k], 0};
    snprintf(part, sizeof part, "%s_%c", name, "xyz"[k]);
    curve(c, k, part, key, "");
  }
  cli_chart_say(c, "\n");
}

/* Linear momentum. */
static void draw_momentum(cli_chart *c) { draw_vector(c, "momentum", "Momentum", "mass*length/time"); }

/* Angular momentum. */
static void draw_angular(cli_chart *c) {
  draw_vector(c, "angular_momentum", "Angular momentum", "mass*length^2/time");
}

/* A text that may stand between single quotes in a script. */
static void quoted(const char *text, char *out, size_t size) {
  size_t n = 0;
  for (; *text && n + 3 < size; text++) {
    if (*text == '\'') out[n++] = '\'';
    out[n++] = (unsigned char)*text < 32 ? ' ' : *text;
  }
  out[n] = 0;
}

/* Rods of a chart with one curve per rod. */
static int rods_shown(const cli_chart *c) {
  return c->info->rod_count < CLI_CHART_RODS ? c->info->rod_count : CLI_CHART_RODS;
}

/* Curves from the table, one per column, named key0, key1 ... */
static void send_table(cli_chart *c, const char *name, int columns) {
  for (int n = 0; n < columns; n++) {
    cli_chart_say(c, "$%s%d << EOD\n", name, n);
    for (long k = 0; k < c->info->frames; k = next_frame(c, k))
      cli_chart_say(c, "%.9g %.9g\n", c->times[k], c->table[(size_t)k * CLI_CHART_RODS + (size_t)n]);
    cli_chart_say(c, "EOD\n");
  }
}

/* Total twist of every rod, in turns. */
static void draw_twist(cli_chart *c) {
  int rods = rods_shown(c);
  for (long k = 0; k < c->info->frames && c->status == HB_OK; k = next_frame(c, k)) {
    c->status = hb_reader_field(c->reader, "twist", k, c->field, c->err);
    for (int n = 0; n < rods && c->status == HB_OK; n++) {
      const hb_reader_rod *rod = &c->info->rods[n];
      double sum = 0;
      for (int i = 1; i < rod->nv - 1; i++) sum += c->field[rod->first + i];
      c->table[(size_t)k * CLI_CHART_RODS + (size_t)n] = sum / 6.283185307179586;
    }
  }
  if (c->status != HB_OK) return;
  send_table(c, "twist", rods);
  begin_time(c, "Twist", "turns");
  for (int n = 0; n < rods; n++) {
    char data[32], key[128];
    snprintf(data, sizeof data, "twist%d", n);
    quoted(c->info->rods[n].name, key, sizeof key);
    curve(c, n, data, key, "");
  }
  cli_chart_say(c, "\n");
}

/* Size of a vector field's or scalar field's value at a slot. */
static double value_at(const double *field, int components, int slot) {
  if (components == 1) return field[slot];
  const double *v = field + (size_t)slot * (size_t)components;
  double sum = 0;
  for (int k = 0; k < components; k++) sum += v[k] * v[k];
  return sqrt(sum);
}

/* Slots where a field is not zero in the frames looked at: where supports act. Returns their number. */
static int acting_slots(cli_chart *c, const char *name, int components, int slots[MOST_SUPPORTS]) {
  int count = 0;
  const long looked[3] = {c->info->frames - 1, c->info->frames / 2, 0};
  for (int n = 0; n < 3 && c->status == HB_OK; n++) {
    c->status = hb_reader_field(c->reader, name, looked[n], c->field, c->err);
    for (int i = 0; i < c->info->nv && c->status == HB_OK; i++) {
      bool known = value_at(c->field, components, i) == 0;
      for (int k = 0; k < count; k++) known = known || slots[k] == i;
      if (!known && count < MOST_SUPPORTS) slots[count++] = i;
    }
  }
  return count;
}

/* The rod that a slot belongs to. */
static const hb_reader_rod *rod_of(const cli_chart *c, int slot) {
  int n = 0;
  while (n + 1 < c->info->rod_count && c->info->rods[n + 1].first <= slot) n++;
  return &c->info->rods[n];
}

/* A field at the slots where it acts, over time. */
static void draw_supports(cli_chart *c, const char *name, int components, const char *title,
                          const char *unit) {
  int slots[MOST_SUPPORTS], count = acting_slots(c, name, components, slots);
  for (long k = 0; k < c->info->frames && c->status == HB_OK; k = next_frame(c, k)) {
    c->status = hb_reader_field(c->reader, name, k, c->field, c->err);
    for (int n = 0; n < count && c->status == HB_OK; n++)
      c->table[(size_t)k * CLI_CHART_RODS + (size_t)n] = value_at(c->field, components, slots[n]);
  }
  if (c->status != HB_OK) return;
  begin_time(c, title, unit);
  if (count == 0) {
    double start = c->times[0], end = c->times[c->info->frames - 1];
    if (!(end > start)) end = start + 1;
    cli_chart_say(c,
                  "set label 1 'all %s are zero' at graph 0.5,0.6 center\n"
                  "plot [%.9g:%.9g] [-1:1] 0 with lines lw 2 lc rgb '%s' notitle\nunset label 1\n",
                  components == 1 ? "torques" : "reactions", start, end, colors[0]);
    return;
  }
  send_table(c, name, count);
  for (int n = 0; n < count; n++) {
    char data[48], rod[128], key[192];
    const hb_reader_rod *r = rod_of(c, slots[n]);
    quoted(r->name, rod, sizeof rod);
    snprintf(data, sizeof data, "%s%d", name, n);
    snprintf(key, sizeof key, "%s, %s %d", rod, components == 1 ? "edge" : "vertex", slots[n] - r->first);
    curve(c, n, data, key, "");
  }
  cli_chart_say(c, "\n");
}

/* Forces of the supports. */
static void draw_reactions(cli_chart *c) {
  draw_supports(c, "reaction", 3, "Reactions of the supports", "force");
}

/* Torques of the clamps. */
static void draw_torque(cli_chart *c) {
  draw_supports(c, "torque", 1, "Torque of the clamps about the rod", "force*length");
}

/* One frame of a scalar field against arc length. */
static void send_along(cli_chart *c, const char *name, hb_location where, int n) {
  const hb_reader_rod *rod = &c->info->rods[c->rod];
  if (c->status == HB_OK) c->status = hb_reader_field(c->reader, name, c->frames[n], c->field, c->err);
  if (c->status == HB_OK) c->status = hb_reader_field(c->reader, "position", c->frames[n], c->points, c->err);
  if (c->status != HB_OK) return;
  cli_chart_say(c, "$%s%d << EOD\n", name, n);
  double arc = 0;
  for (int i = 0; i < rod->nv; i++) {
    const double *p = c->points + 3 * ((size_t)rod->first + (size_t)i);
    double next = 0;
    for (int k = 0; k < 3 && i + 1 < rod->nv; k++) next += (p[3 + k] - p[k]) * (p[3 + k] - p[k]);
    next = sqrt(next);
    bool inside = where == HB_ON_EDGE ? i + 1 < rod->nv : i > 0 && i + 1 < rod->nv;
    if (inside)
      cli_chart_say(c, "%.9g %.9g\n", where == HB_ON_EDGE ? arc + 0.5 * next : arc, c->field[rod->first + i]);
    arc += next;
  }
  cli_chart_say(c, "EOD\n");
}

/* A scalar field along the rod at the frames chosen, light to dark in time. */
static void draw_along(cli_chart *c, const char *name, const char *title) {
  const hb_frame_field *field = NULL;
  for (int k = 0; k < hb_frame_field_count; k++)
    if (strcmp(hb_frame_fields[k].name, name) == 0) field = &hb_frame_fields[k];
  if (!field) return;
  for (int n = 0; n < c->frame_count; n++) send_along(c, name, field->location, n);
  char rod[128];
  quoted(c->info->rods[c->rod].name, rod, sizeof rod);
  cli_chart_say(c, "set title '%s along %s'\nset xlabel 'arc length'\nset ylabel '%s'\nset xrange [0:*]\n",
                title, rod, field->unit);
  for (int n = 0; n < c->frame_count; n++) {
    double f = c->frame_count > 1 ? (double)n / (c->frame_count - 1) : 1;
    int r = (int)(226 - f * 206), g = (int)(186 - f * 110), b = (int)(120 - f * 10);
    cli_chart_say(c, "%s $%s%d using 1:2 with lines lw 2 lc rgb '#%02x%02x%02x' title 't = %.4g'",
                  n ? "," : "plot", name, n, r, g, b, c->times[c->frames[n]]);
  }
  cli_chart_say(c, "\nset xrange [*:*]\n");
}

/* Curvature along the rod. */
static void draw_curvature(cli_chart *c) { draw_along(c, "curvature", "Curvature"); }

/* Twist per length along the rod. */
static void draw_twist_density(cli_chart *c) { draw_along(c, "twist_density", "Twist density"); }

/* Axial force along the rod. */
static void draw_tension(cli_chart *c) { draw_along(c, "tension", "Tension"); }

/* Twisting moment along the rod. */
static void draw_moment(cli_chart *c) { draw_along(c, "twisting_moment", "Twisting moment"); }

const cli_chart_kind cli_chart_kinds[] = {
    {"energies", "kinetic, bending and twisting energy and the error of their balance, over time",
     draw_energies},
    {"balance", "work of loads and supports, dissipation, error of the balance, over time", draw_balance},
    {"twist", "total twist of each rod in turns, over time", draw_twist},
    {"length", "relative error of the edge lengths, logarithmic, over time", draw_length},
    {"momentum", "components of the momentum, over time", draw_momentum},
    {"angular_momentum", "components of the angular momentum, over time", draw_angular},
    {"reactions", "size of the forces of the supports, over time", draw_reactions},
    {"torque", "torque of clamped frames about the rod, over time", draw_torque},
    {"curvature", "curvature along the rod at some frames", draw_curvature},
    {"twist_density", "twist per length along the rod at some frames", draw_twist_density},
    {"tension", "axial force along the rod at some frames", draw_tension},
    {"moment", "twisting moment along the rod at some frames", draw_moment}};
const int cli_chart_kind_count = sizeof cli_chart_kinds / sizeof cli_chart_kinds[0];
