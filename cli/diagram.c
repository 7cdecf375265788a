/* Diagram of branches: one quantity over another, stable parts solid, unstable ones dashed, with pictures of
 * shapes beside it. */
#include "cli/diagram.h"

#include "base/memory.h"
#include "cli/chart.h"
#include "cli/picture.h"

#include <errno.h>
#include <getopt.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { COLUMNS = 64, SHAPES = 12, TEXT_ROOM = 4096 };

/* The columns that every table has. */
enum { BRANCH, INDEX, KIND, UNSTABLE, X, Y, NEEDED };

typedef struct request {
  const char *path, *out, *x, *y;
  int shapes, width, height;
} request;

/* A point of a branch. */
typedef struct point {
  long branch, index;
  char kind; /* first letter of its kind */
  bool unstable;
  double x, y;
} point;

typedef struct diagram {
  request ask;
  char *text; /* of the table */
  point *points;
  long count;
  long chosen[SHAPES]; /* points whose shapes are drawn */
  int chosen_count;
  double *shape[SHAPES]; /* their positions */
  int nv;
  int across, up;         /* axes that the shapes are drawn in */
  double low[3], high[3]; /* of all shapes */
  cli_chart *chart;       /* takes the script */
} diagram;

/* A table that a trace has left. */
bool cli_wants_diagram(int argc, char **argv) {
  for (int k = 1; k < argc; k++)
    if (cli_ends_with(argv[k], ".csv")) return true;
  return false;
}

/* Parses argv; an exit status, or -1 to go on. */
static int parse(int argc, char **argv, request *r) {
  static const struct option longs[] = {
      {"output", required_argument, NULL, 'o'}, {"x", required_argument, NULL, 'x'},
      {"y", required_argument, NULL, 'y'},      {"shapes", required_argument, NULL, 'n'},
      {"size", required_argument, NULL, 's'},   {NULL, 0, NULL, 0}};
  static const int least[2] = {300, 200};
  *r = (request){
      .out = "plot.png", .x = "parameter", .y = "amplitude", .shapes = 6, .width = 1400, .height = 700};
  opterr = 0;
  optind = 1;
  for (int c; (c = getopt_long(argc, argv, ":o:", longs, NULL)) != -1;) {
    switch (c) {
    case 'o': r->out = optarg; break;
    case 'x': r->x = optarg; break;
    case 'y': r->y = optarg; break;
    case 'n':
      if (strcmp(optarg, "0") == 0)
        r->shapes = 0;
      else if (!cli_whole(optarg, SHAPES, &r->shapes))
        return cli_usage(&cli_verb_plot, "--shapes \"%s\" is not a whole number from 0 to %d", optarg,
                         SHAPES);
      break;
    case 's':
      if (!cli_read_size(optarg, least, &r->width, &r->height))
        return cli_usage(&cli_verb_plot, "--size needs WIDTHxHEIGHT, 300x200 to 8192x8192, found '%s'",
                         optarg);
      break;
    case ':': return cli_usage(&cli_verb_plot, "%s needs a value", argv[optind - 1]);
    default: return cli_usage(&cli_verb_plot, "%s is no option for a table of branches", argv[optind - 1]);
    }
  }
  if (optind + 1 != argc) return cli_usage(&cli_verb_plot, "one table of branches is expected");
  r->path = argv[optind];
  if (!cli_ends_with(r->out, ".png") && !cli_ends_with(r->out, ".svg"))
    return cli_usage(&cli_verb_plot, "-o %s: the name must end in .png or .svg", r->out);
  return -1;
}

/* The whole table as text. */
static hb_status read_text(diagram *d, hb_error *err) {
  FILE *file = fopen(d->ask.path, "rb");
  if (!file) return hb_fail(err, HB_ERR_INPUT, "%s: cannot be opened: %s", d->ask.path, strerror(errno));
  long size = fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
  bool good = size >= 0 && fseek(file, 0, SEEK_SET) == 0;
  d->text = good ? hb_alloc((size_t)size + 1, 1) : NULL;
  if (good && !d->text) {
    fclose(file);
    return hb_fail_memory(err, "table of branches");
  }
  good = good && fread(d->text, 1, (size_t)size, file) == (size_t)size;
  fclose(file);
  return good ? HB_OK : hb_fail(err, HB_ERR_IO, "%s: cannot be read", d->ask.path);
}

/* Cuts a line at its commas; the number of parts. */
static int cut(char *line, char *parts[COLUMNS]) {
  int count = 0;
  for (char *at = line; at && count < COLUMNS; count++) {
    parts[count] = at;
    at = strchr(at, ',');
    if (at) *at++ = 0;
  }
  return count;
}

/* Which columns are wanted, from the first line. */
static hb_status find_columns(const diagram *d, char *line, int where[NEEDED], hb_error *err) {
  const char *const names[NEEDED] = {"branch", "index", "kind", "unstable", d->ask.x, d->ask.y};
  char *parts[COLUMNS], all[900] = "";
  int count = cut(line, parts);
  for (int k = 0; k < count; k++) {
    size_t used = strlen(all);
    snprintf(all + used, sizeof all - used, "%s%.40s", k ? ", " : "", parts[k]);
  }
  for (int n = 0; n < NEEDED; n++) {
    where[n] = -1;
    for (int k = 0; k < count; k++)
      if (strcmp(parts[k], names[n]) == 0) where[n] = k;
    if (where[n] < 0)
      return hb_fail(err, HB_ERR_INPUT, "%s: there is no column \"%s\"; its columns are %s", d->ask.path,
                     names[n], all);
  }
  return HB_OK;
}

/* All points. */
static hb_status read_points(diagram *d, hb_error *err) {
  int where[NEEDED], line_number = 1, most = 0;
  hb_status status = read_text(d, err);
  if (status) return status;
  long lines = 0;
  for (const char *p = d->text; *p; p++) lines += *p == '\n';
  d->points = hb_alloc((size_t)lines + 1, sizeof *d->points);
  if (!d->points) return hb_fail_memory(err, "points of the branches");
  char *line = d->text, *next = strchr(line, '\n');
  if (next) *next++ = 0;
  status = find_columns(d, line, where, err);
  for (int n = 0; n < NEEDED; n++) most = where[n] > most ? where[n] : most;
  for (line = next; !status && line && *line; line = next) {
    char *parts[COLUMNS], *end;
    next = strchr(line, '\n');
    if (next) *next++ = 0;
    line_number++;
    if (cut(line, parts) <= most)
      return hb_fail(err, HB_ERR_INPUT, "%s:%d: the line has too few columns", d->ask.path, line_number);
    point *p = &d->points[d->count++];
    *p = (point){.branch = strtol(parts[where[BRANCH]], NULL, 10),
                 .index = strtol(parts[where[INDEX]], NULL, 10),
                 .kind = parts[where[KIND]][0],
                 .unstable = strtol(parts[where[UNSTABLE]], NULL, 10) > 0,
                 .x = strtod(parts[where[X]], &end)};
    bool good = end != parts[where[X]];
    p->y = strtod(parts[where[Y]], &end);
    if (!good || end == parts[where[Y]] || !isfinite(p->x) || !isfinite(p->y))
      return hb_fail(err, HB_ERR_INPUT, "%s:%d: a number is expected under %s and %s", d->ask.path,
                     line_number, d->ask.x, d->ask.y);
  }
  if (!status && d->count == 0) return hb_fail(err, HB_ERR_INPUT, "%s: the table has no points", d->ask.path);
  return status;
}

/* Shapes far apart from one another: of those that are left the farthest from all that are chosen, in the
 * plane of the diagram, each axis in units of its range; shapes differ
 * more over the second one. */
static void choose_shapes(diagram *d) {
  double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
  for (long k = 0; k < d->count; k++) {
    low[0] = fmin(low[0], d->points[k].x), high[0] = fmax(high[0], d->points[k].x);
    low[1] = fmin(low[1], d->points[k].y), high[1] = fmax(high[1], d->points[k].y);
  }
  double size[2] = {fmax(high[0] - low[0], 1e-300), fmax(high[1] - low[1], 1e-300)};
  while (d->chosen_count < d->ask.shapes) {
    long best = -1;
    double farthest = 1e-3;
    for (long k = 0; k < d->count; k++) {
      double least = d->chosen_count == 0 ? fabs(d->points[k].y) / size[1] + 1 : HUGE_VAL;
      for (int c = 0; c < d->chosen_count; c++) {
        const point *other = &d->points[d->chosen[c]];
        least = fmin(
            least, hypot(0.4 * (d->points[k].x - other->x) / size[0], (d->points[k].y - other->y) / size[1]));
      }
      if (least > farthest) {
        farthest = least;
        best = k;
      }
    }
    if (best < 0) break;
    d->chosen[d->chosen_count++] = best;
  }
  for (int i = 1; i < d->chosen_count; i++) /* in the order of the table */
    for (int j = i; j > 0 && d->chosen[j] < d->chosen[j - 1]; j--) {
      long swapped = d->chosen[j];
      d->chosen[j] = d->chosen[j - 1];
      d->chosen[j - 1] = swapped;
    }
}

/* The shape of one chosen point, from the trajectory of its branch beside the table. */
static hb_status read_shape(diagram *d, int which, hb_error *err) {
  char path[PATH_MAX];
  const point *p = &d->points[d->chosen[which]];
  const char *slash = strrchr(d->ask.path, '/');
  hb_reader *reader = NULL;
  snprintf(path, sizeof path, "%.*sbranch-%ld.h5", slash ? (int)(slash - d->ask.path + 1) : 0, d->ask.path,
           p->branch);
  hb_status status = hb_reader_open(path, &reader, err);
  if (status) return status;
  const hb_trajectory_info *info = hb_reader_info(reader);
  if (p->index < 0 || p->index >= info->frames || (d->nv && d->nv != info->nv))
    status = hb_fail(err, HB_ERR_INPUT, "%s: has no frame %ld of the rod: it does not belong to %s", path,
                     p->index, d->ask.path);
  d->nv = info->nv;
  if (!status) {
    d->shape[which] = hb_alloc(3 * (size_t)d->nv, sizeof *d->shape[which]);
    status = d->shape[which] ? hb_reader_field(reader, "position", p->index, d->shape[which], err)
                             : hb_fail_memory(err, "shapes beside the diagram");
  }
  hb_reader_close(reader);
  return status;
}

/* All shapes, and the two axes along which they are largest. */
static hb_status read_shapes(diagram *d, hb_error *err) {
  hb_status status = HB_OK;
  double extent[3];
  for (int c = 0; c < 3; c++) d->low[c] = HUGE_VAL, d->high[c] = -HUGE_VAL, extent[c] = 0;
  for (int k = 0; !status && k < d->chosen_count; k++) {
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    status = read_shape(d, k, err);
    for (int i = 0; !status && i < 3 * d->nv; i++) {
      low[i % 3] = fmin(low[i % 3], d->shape[k][i]);
      high[i % 3] = fmax(high[i % 3], d->shape[k][i]);
    }
    for (int c = 0; !status && c < 3; c++) {
      d->low[c] = fmin(d->low[c], low[c]);
      d->high[c] = fmax(d->high[c], high[c]);
      extent[c] += high[c] - low[c];
    }
  }
  int least = extent[1] <= extent[0] && extent[1] <= extent[2] ? 1 : extent[2] <= extent[0] ? 2 : 0;
  d->across = least == 0 ? 1 : 0;
  d->up = least == 2 ? 1 : 2;
  return status;
}

/* Lines of one kind: all stretches of branches that are stable, or not. A stretch begins with the point
 * before it, so that nothing is missing between. */
static void say_lines(diagram *d, bool unstable) {
  for (long k = 0; k < d->count; k++) {
    const point *p = &d->points[k], *before = k > 0 ? p - 1 : NULL;
    bool goes_on = before && before->branch == p->branch;
    if (p->unstable != unstable) continue;
    if (!goes_on) cli_chart_say(d->chart, "\n");
    if (goes_on && before->unstable != unstable)
      cli_chart_say(d->chart, "\n%.17g %.17g\n", before->x, before->y);
    cli_chart_say(d->chart, "%.17g %.17g\n", p->x, p->y);
  }
  cli_chart_say(d->chart, "NaN NaN\ne\n");
}

/* Points of one kind. */
static void say_marks(diagram *d, char kind) {
  for (long k = 0; k < d->count; k++)
    if (d->points[k].kind == kind) cli_chart_say(d->chart, "%.17g %.17g\n", d->points[k].x, d->points[k].y);
  cli_chart_say(d->chart, "NaN NaN\ne\n");
}

/* Sizes, fonts, colours as in the other charts. */
static void say_style(diagram *d) {
  const request *r = &d->ask;
  if (cli_ends_with(r->out, ".svg"))
    cli_chart_say(
        d->chart,
        "set terminal svg size %d,%d dynamic noenhanced font 'DejaVu Sans,13' background '#fcfbf9'\n",
        r->width, r->height);
  else
    cli_chart_say(d->chart,
                  "set terminal pngcairo size %d,%d noenhanced font 'DejaVu Sans,11' background '#fcfbf9'\n",
                  r->width, r->height);
  cli_chart_say(
      d->chart,
      "set multiplot\nset border 3 lc rgb '#8c877e' lw 1\nset tics nomirror out scale 0.6 textcolor rgb "
      "'#5a5750'\nset grid lc rgb '#e4e0d8' lt 1 lw 1\nset xlabel textcolor rgb '#5a5750'\nset ylabel "
      "textcolor rgb '#5a5750'\nset key below center horizontal Left reverse textcolor rgb '#5a5750' "
      "samplen 2\nset autoscale fix\nset offsets graph 0.03,graph 0.03,graph 0.06,graph 0.06\n");
}

/* The diagram itself, with the numbers of the shapes in it. */
static void say_diagram(diagram *d, double width) {
  cli_chart *c = d->chart;
  cli_chart_say(c, "set origin 0,0\nset size %g,1\nset xlabel '%s'\nset ylabel '%s'\n", width, d->ask.x,
                d->ask.y);
  for (int k = 0; k < d->chosen_count; k++)
    cli_chart_say(
        c,
        "set label %d '%d' at %.17g,%.17g offset 0.7,0.6 textcolor rgb '#2c3039' font ',12' front point pt "
        "7 ps 0.8 lc rgb '#2c3039'\n",
        k + 1, k + 1, d->points[d->chosen[k]].x, d->points[d->chosen[k]].y);
  cli_chart_say(
      c, "plot '-' with lines lw 2 lc rgb '#1f6f8b' title 'stable', '-' with lines lw 2 dt 2 lc rgb "
         "'#c8553d' title 'unstable', '-' with points pt 9 ps 1.2 lc rgb '#8a5a00' title 'fold', '-' with "
         "points pt 6 ps 1.4 lw 2 lc rgb '#2c3039' title 'bifurcation'\n");
  say_lines(d, false);
  say_lines(d, true);
  say_marks(d, 'f');
  say_marks(d, 'b');
}

/* Shapes in a grid, all of one scale. */
static void say_shapes(diagram *d, double from) {
  cli_chart *c = d->chart;
  int columns = d->chosen_count > 3 ? 2 : 1, rows = (d->chosen_count + columns - 1) / columns;
  double width = (0.99 - from) / columns, height = 0.94 / rows;
  double middle[2] = {0.5 * (d->low[d->across] + d->high[d->across]), 0.5 * (d->low[d->up] + d->high[d->up])};
  double half = 0.55 * fmax(d->high[d->across] - d->low[d->across], d->high[d->up] - d->low[d->up]);
  double stretch =
      width * d->ask.width / (height * d->ask.height); /* panels are as wide as this times high */
  double half_x = stretch > 1 ? half * stretch : half, half_y = stretch > 1 ? half : half / stretch;
  cli_chart_say(
      c, "unset label\nunset key\nunset border\nunset tics\nunset grid\nunset xlabel\nunset ylabel\nset "
         "margins 0,0,0,0\nset offsets 0,0,0,0\n");
  for (int k = 0; k < d->chosen_count; k++) {
    const point *p = &d->points[d->chosen[k]];
    cli_chart_say(c, "set origin %g,%g\nset size %g,%g\n", from + width * (k % columns),
                  0.97 - height * (k / columns + 1), width * 0.98, height * 0.98);
    cli_chart_say(c, "set xrange [%.9g:%.9g]\nset yrange [%.9g:%.9g]\n", middle[0] - half_x,
                  middle[0] + half_x, middle[1] - half_y, middle[1] + half_y);
    cli_chart_say(c, "set label 1 '%d  %s %.4g' at graph 0.02,0.97 textcolor rgb '#2c3039' font ',10'\n",
                  k + 1, d->ask.x, p->x);
    cli_chart_say(c, "plot '-' with lines lw 3 lc rgb '%s'\n", p->unstable ? "#c8553d" : "#1f6f8b");
    for (int i = 0; i < d->nv; i++)
      cli_chart_say(c, "%.9g %.9g\n", d->shape[k][3 * i + d->across], d->shape[k][3 * i + d->up]);
    cli_chart_say(c, "e\n");
  }
}

/* Starts gnuplot, sends the script, puts the picture in place. */
static hb_status draw(diagram *d, hb_error *err) {
  char part[TEXT_ROOM];
  const char *const argv[] = {"gnuplot", "-", NULL};
  cli_chart *c = d->chart;
  c->err = err;
  int length = snprintf(part, sizeof part, "%s.part", d->ask.out);
  if (length < 1 || (size_t)length >= sizeof part)
    return hb_fail(err, HB_ERR_INPUT, "-o %s: the name is too long", d->ask.out);
  hb_status writable = cli_try_file(part, d->ask.out, "picture", err);
  if (writable) return writable;
  c->status = cli_pipe_open(&c->pipe, argv, "gnuplot-nox", part, err);
  if (c->status) {
    remove(part);
    return c->status;
  }
  double width = d->chosen_count == 0 ? 1 : d->chosen_count > 3 ? 0.55 : 0.7;
  say_style(d);
  say_diagram(d, width);
  if (d->chosen_count > 0) say_shapes(d, width + 0.01);
  cli_chart_say(c, "unset multiplot\n");
  cli_chart_flush(c);
  hb_status status = c->status, closing = cli_pipe_close(&c->pipe, status ? NULL : err);
  if (!status) status = closing;
  if (!status && rename(part, d->ask.out) != 0)
    status =
        hb_fail(err, HB_ERR_IO, "%s: the picture cannot be put in place: %s", d->ask.out, strerror(errno));
  if (status)
    remove(part);
  else
    printf("%s: %ld points, %d shapes\n", d->ask.out, d->count, d->chosen_count);
  return status;
}

/* The verb's other half. */
int cli_draw_diagram(int argc, char **argv) {
  diagram d;
  hb_error err = {HB_OK, ""};
  memset(&d, 0, sizeof d);
  int result = parse(argc, argv, &d.ask);
  if (result >= 0) return result;
  d.chart = hb_alloc(1, sizeof *d.chart);
  hb_status status = d.chart ? read_points(&d, &err) : hb_fail_memory(&err, "charts");
  if (!status) choose_shapes(&d);
  if (!status) status = read_shapes(&d, &err);
  if (!status) status = draw(&d, &err);
  for (int k = 0; k < SHAPES; k++) hb_free(d.shape[k]);
  hb_free(d.points);
  hb_free(d.text);
  hb_free(d.chart);
  return status ? cli_fail("plot", &err) : CLI_DONE;
}
