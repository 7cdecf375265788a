/* A picture for every case, by one gnuplot: errors against tolerances, and where the rods end. */
#include "base/memory.h"
#include "cli/pipe.h"
#include "cli/validate.h"
#include "output/file.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>

/* The script on its way. */
typedef struct drawing {
  cli_pipe pipe;
  hb_status status;
  hb_error *err;
} drawing;

enum { CURVES = 8 };
static const char *const colors[CURVES] = {"#26708a", "#c95a45", "#5c549e", "#d99e38",
                                           "#4f8050", "#944a73", "#5494ad", "#8c6647"};

/* Sends formatted text; less than 4 kilobytes. */
HB_PRINTF(2, 3) static void say(drawing *d, const char *format, ...) {
  char text[4096];
  if (d->status) return;
  va_list args;
  va_start(args, format);
  int length = vsnprintf(text, sizeof text, format, args);
  va_end(args);
  if (length > (int)sizeof text - 1) length = (int)sizeof text - 1;
  d->status = cli_pipe_write(&d->pipe, text, (size_t)length, d->err);
}

/* Text for gnuplot's single quotes. */
static const char *quoted(const char *text, char *buffer, size_t size) {
  size_t n = 0;
  for (; *text && n + 3 < size; text++) {
    if (*text == '\'') buffer[n++] = '\'';
    buffer[n++] = (unsigned char)*text < 32 ? ' ' : *text;
  }
  buffer[n] = 0;
  return buffer;
}

/* Error of a verdict at a mesh in parts of its tolerance, never 0 (for logarithms); NAN if there is none. */
static double share(const cli_validation *v, const cli_verdict *w, int mesh) {
  const cli_point *points = cli_case_points(v, w->of), *at = &points[w->variant * w->of->mesh_count + mesh];
  int index = (int)(w->expect - w->of->expects);
  if (at->err.status || points[0].err.status) return (double)NAN;
  double known = w->expect->same ? points[0].found[index] : at->expected[index];
  double error = fabs(at->found[index] - known) / (w->relative ? fabs(known) : 1);
  return fmax(error, 1e-16);
}

/* Errors over the size of the mesh, both logarithmic, up to CURVES verdicts; those with an order first. */
static void draw_convergence(drawing *d, const cli_validation *v, const cli_case *c) {
  const cli_verdict *chosen[CURVES];
  char text[300], label[200], title[560];
  int count = 0;
  for (int pass = 0; pass < 2; pass++)
    for (int k = 0; k < v->verdict_count && count < CURVES; k++)
      if (v->verdicts[k].of == c && (v->verdicts[k].expect->order > 0) == (pass == 0))
        chosen[count++] = &v->verdicts[k];
  for (int k = 0; k < count; k++) {
    say(d, "$e%d << EOD\n", k);
    for (int m = 0; m < c->mesh_count; m++) {
      const cli_point *at = cli_case_points(v, c) + chosen[k]->variant * c->mesh_count + m;
      double y = share(v, chosen[k], m), x = c->size ? at->size : m + 1;
      if (isfinite(y) && (x > 0)) say(d, "%.9g %.9g\n", x, y);
    }
    say(d, "EOD\n");
  }
  say(d, "set title 'errors'\nset xlabel '%s'\nset ylabel '|found - expected|'\nset logscale y\n",
      c->size ? "size of the mesh" : c->meshes->children[0]->key);
  if (c->size) say(d, "set logscale x\n");
  for (int m = 0; !c->size && m < c->mesh_count; m++)
    say(d, "%s'%s' %d%s", m ? ", " : "set xtics (",
        quoted(c->meshes->children[0]->children[m]->text, text, sizeof text), m + 1,
        m + 1 < c->mesh_count ? "" : ")\n");
  for (int k = 0; k < count; k++) {
    cli_case_label(c, chosen[k]->variant, label, sizeof label);
    snprintf(title, sizeof title, "%.200s%s%s", chosen[k]->expect->name, label[0] ? ", " : "", label);
    if (chosen[k]->expect->order > 0) {
      size_t used = strlen(title);
      snprintf(title + used, sizeof title - used, " (order %.2f)", chosen[k]->order);
    }
    say(d, "%s $e%d using 1:2 with linespoints pt 7 ps 0.8 lw 2 lc rgb '%s' title '%s'", k ? "," : "plot", k,
        colors[k], quoted(title, text, sizeof text));
    say(d, ", %.9g with lines dt 3 lc rgb '%s' notitle", chosen[k]->tolerance, colors[k]);
  }
  say(d, "\nunset logscale\nset xtics autofreq\n");
}

/* One bar per verdict: its error and its tolerance. */
static void draw_bars(drawing *d, const cli_validation *v, const cli_case *c) {
  int row = 0;
  say(d, "$bars << EOD\n");
  for (int k = 0; k < v->verdict_count; k++) {
    const cli_verdict *w = &v->verdicts[k];
    char label[200], name[500], text[520];
    if (w->of != c) continue;
    cli_case_label(c, w->variant, label, sizeof label);
    snprintf(name, sizeof name, "%.120s%s%s", w->expect->name, label[0] ? ", " : "", label);
    for (char *p = name; *p; p++)
      if (*p == '"' || *p == '\\') *p = ' ';
    double error = fmax(fabs(w->error), 1e-17);
    if (isfinite(error))
      say(d, "%d %.9g %.9g \"%.40s\"\n", row, error, w->tolerance, quoted(name, text, sizeof text));
    row++;
  }
  say(d,
      "EOD\nset title 'errors and tolerances'\nset xlabel '|found - expected|'\nset ylabel ''\nset logscale "
      "x\n"
      "set yrange [-0.7:%g] reverse\n",
      row - 0.3);
  say(d, "plot $bars using 2:1:(0):2:($1-0.3):($1+0.3):ytic(4) with boxxyerror fs solid 0.7 noborder lc rgb "
         "'#26708a' "
         "title 'error', $bars using 3:1 with points pt 2 ps 1.2 lw 2 lc rgb '#c95a45' title 'tolerance'\n"
         "unset logscale\nset yrange [*:*] noreverse\nset ytics autofreq\n");
}

/* The two axes along which a shape extends furthest. */
static void widest(const double *shape, int nv, int axes[2], double extent[3]) {
  for (int c = 0; c < 3; c++) {
    double least = HUGE_VAL, most = -HUGE_VAL;
    for (int k = 0; k < nv; k++) {
      least = fmin(least, shape[3 * k + c]);
      most = fmax(most, shape[3 * k + c]);
    }
    extent[c] = most - least;
  }
  int smallest = extent[2] <= extent[0] && extent[2] <= extent[1] ? 2 : extent[1] <= extent[0] ? 1 : 0;
  axes[0] = smallest == 0 ? 1 : 0;
  axes[1] = smallest == 2 ? 1 : 2;
}

/* Where the rods end on the finest mesh, for up to CURVES columns. */
static void draw_shape(drawing *d, const cli_validation *v, const cli_case *c) {
  const cli_point *points = cli_case_points(v, c);
  int axes[2] = {0, 1}, count = 0, drawn[CURVES];
  double extent[3] = {1, 1, 1};
  for (int variant = 0; variant < c->variants && count < CURVES; variant++) {
    const cli_point *at = &points[variant * c->mesh_count + c->mesh_count - 1];
    int nv = 0, slot = 0;
    if (!at->shape) continue;
    for (int r = 0; at->rods[r]; r++) nv += at->rods[r];
    if (count == 0) widest(at->shape, nv, axes, extent);
    say(d, "$s%d << EOD\n", count);
    for (int r = 0; at->rods[r]; r++, say(d, "\n"))
      for (int k = 0; k < at->rods[r]; k++, slot++)
        say(d, "%.7g %.7g\n", at->shape[3 * slot + axes[0]], at->shape[3 * slot + axes[1]]);
    say(d, "EOD\n");
    drawn[count++] = variant;
  }
  if (count == 0) {
    say(d, "set multiplot next\n");
    return;
  }
  bool flat = extent[axes[0]] < 0.12 * extent[axes[1]] || extent[axes[1]] < 0.12 * extent[axes[0]];
  say(d, "set title 'shape%s%s'\nset xlabel '%c'\nset ylabel '%c'\n%s",
      c->mesh_count > 1 ? " on the finest mesh" : "", flat ? ", stretched" : "", "xyz"[axes[0]],
      "xyz"[axes[1]], flat ? "" : "set size ratio -1\n");
  for (int k = 0; k < count; k++) {
    char label[200], text[300];
    cli_case_label(c, drawn[k], label, sizeof label);
    say(d, "%s $s%d using 1:2 with lines lw 2 lc rgb '%s' title '%s'", k ? "," : "plot", k, colors[k],
        quoted(label, text, sizeof text));
  }
  say(d, "\nset size noratio\n");
}

/* One picture. */
static void draw_case(drawing *d, const cli_validation *v, const cli_case *c, const char *directory) {
  char text[600], title[400];
  snprintf(title, sizeof title, "%s%s%s", c->id ? c->id : "", c->id ? ": " : "", c->title);
  char *path = hb_file_join(directory, "%s.png", c->name),
       *name = path ? hb_alloc(2 * strlen(path) + 4, 1) : NULL;
  if (!name)
    d->status = hb_fail_memory(d->err, "name of a plot");
  else
    say(d, "set output '%s'\n", quoted(path, name, 2 * strlen(path) + 4));
  hb_free(path);
  hb_free(name);
  say(d, "set multiplot layout 1,2 title '%s' font ',13' textcolor rgb '#2c3039'\n",
      quoted(title, text, sizeof text));
  if (c->mesh_count > 1)
    draw_convergence(d, v, c);
  else
    draw_bars(d, v, c);
  draw_shape(d, v, c);
  say(d, "unset multiplot\nunset output\n");
}

/* All pictures. */
hb_status cli_validation_plot(const cli_validation *v, const char *directory, hb_error *err) {
  const char *const argv[] = {"gnuplot", "-", NULL};
  drawing d = {.err = err};
  hb_status status = hb_file_directory(directory, err);
  if (!status) status = cli_pipe_open(&d.pipe, argv, "gnuplot-nox", NULL, err);
  if (status) return status;
  say(&d, "set terminal pngcairo size 1300,480 noenhanced font 'DejaVu Sans,10' background '#fcfbf9'\n"
          "set border 3 lc rgb '#8c877e' lw 1\nset tics nomirror out scale 0.6 textcolor rgb '#5a5750'\n"
          "set grid lc rgb '#e4e0d8' lt 1 lw 1\nset key below center horizontal Left reverse samplen 2\n"
          "set format y '%%g'\nset rmargin 4\n");
  for (int k = 0; k < v->case_count && !d.status; k++)
    if (v->cases[k]->deed != CLI_NOT_YET) draw_case(&d, v, v->cases[k], directory);
  status = d.status;
  hb_status closing = cli_pipe_close(&d.pipe, status ? NULL : err);
  return status ? status : closing;
}
