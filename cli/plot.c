/* hebra plot: curves of a trajectory, as PNG or SVG. */
#include "cli/chart.h"
#include "cli/diagram.h"
#include "cli/picture.h"

#include "base/memory.h"

#include <errno.h>
#include <getopt.h>
#include <stdlib.h>
#include <string.h>

enum { TEXT_ROOM = 4096 };

/* What was asked for. */
typedef struct request {
  const char *path, *out, *what, *frames, *rod;
  int width, height; /* 0: from the number of panels */
  const cli_chart_kind *kinds[CLI_CHART_PANELS];
  int kind_count;
} request;

/* The kind of that name. */
static const cli_chart_kind *find_kind(const char *name, size_t length) {
  for (int k = 0; k < cli_chart_kind_count; k++)
    if (strlen(cli_chart_kinds[k].name) == length && strncmp(cli_chart_kinds[k].name, name, length) == 0)
      return &cli_chart_kinds[k];
  return NULL;
}

/* Names with commas to kinds; an exit status, or -1 to go on. */
static int read_kinds(request *r) {
  const char *at = r->what;
  for (;;) {
    size_t length = strcspn(at, ",");
    const cli_chart_kind *kind = find_kind(at, length);
    if (!kind) {
      char all[512] = "";
      for (int k = 0; k < cli_chart_kind_count; k++) {
        size_t used = strlen(all);
        snprintf(all + used, sizeof all - used, "%s%s", k ? ", " : "", cli_chart_kinds[k].name);
      }
      return cli_usage(&cli_verb_plot, "--what: there is no '%.*s'; allowed are %s", (int)length, at, all);
    }
    if (r->kind_count == CLI_CHART_PANELS)
      return cli_usage(&cli_verb_plot, "--what: at most %d charts in one picture", CLI_CHART_PANELS);
    r->kinds[r->kind_count++] = kind;
    at += length;
    if (!*at) return -1;
    at++;
  }
}

/* Parses argv; an exit status, or -1 to go on. */
static int parse(int argc, char **argv, request *r) {
  static const struct option longs[] = {
      {"output", required_argument, NULL, 'o'}, {"what", required_argument, NULL, 'w'},
      {"frames", required_argument, NULL, 'f'}, {"rod", required_argument, NULL, 'r'},
      {"size", required_argument, NULL, 's'},   {NULL, 0, NULL, 0}};
  static const int least[2] = {200, 150};
  *r = (request){.out = "plot.png", .what = "energies,twist,length,curvature"};
  opterr = 0;
  for (int c; (c = getopt_long(argc, argv, ":o:", longs, NULL)) != -1;) {
    switch (c) {
    case 'o': r->out = optarg; break;
    case 'w': r->what = optarg; break;
    case 'f': r->frames = optarg; break;
    case 'r': r->rod = optarg; break;
    case 's':
      if (!cli_read_size(optarg, least, &r->width, &r->height))
        return cli_usage(&cli_verb_plot, "--size needs WIDTHxHEIGHT, 200x150 to 8192x8192, found '%s'",
                         optarg);
      break;
    case ':': return cli_usage(&cli_verb_plot, "%s needs a value", argv[optind - 1]);
    default: return cli_usage(&cli_verb_plot, "unknown option %s", argv[optind - 1]);
    }
  }
  int result = cli_read_trajectory(&cli_verb_plot, argc, argv, &r->path);
  if (result >= 0) return result;
  if (!cli_ends_with(r->out, ".png") && !cli_ends_with(r->out, ".svg"))
    return cli_usage(&cli_verb_plot, "-o %s: the name must end in .png or .svg", r->out);
  return read_kinds(r);
}

/* Frames along the rod: those asked for, or five from the first to the last. */
static hb_status pick_frames(const request *r, cli_chart *c, hb_error *err) {
  long frames = c->info->frames;
  if (!r->frames) {
    for (int k = 0; k < 5; k++) {
      long frame = (frames - 1) * k / 4;
      if (c->frame_count == 0 || frame != c->frames[c->frame_count - 1]) c->frames[c->frame_count++] = frame;
    }
    return HB_OK;
  }
  for (const char *at = r->frames; *at;) {
    char *end = NULL;
    errno = 0;
    long frame = strtol(at, &end, 10), counted = frame < 0 ? frame + frames : frame;
    if (end == at || errno || (*end && *end != ',') || counted < 0 || counted >= frames)
      return hb_fail(err, HB_ERR_INPUT, "--frames %s: whole numbers from %ld to %ld with commas are allowed",
                     r->frames, -frames, frames - 1);
    if (c->frame_count == CLI_CHART_FRAMES)
      return hb_fail(err, HB_ERR_INPUT, "--frames: at most %d frames in one chart", CLI_CHART_FRAMES);
    c->frames[c->frame_count++] = counted;
    at = *end ? end + 1 : end;
  }
  return HB_OK;
}

/* The rod asked for, by name or number. */
static hb_status pick_rod(const request *r, cli_chart *c, hb_error *err) {
  if (!r->rod) return HB_OK;
  for (c->rod = 0; c->rod < c->info->rod_count; c->rod++)
    if (strcmp(c->info->rods[c->rod].name, r->rod) == 0) return HB_OK;
  char *end = NULL;
  long number = strtol(r->rod, &end, 10);
  if (end == r->rod || *end || number < 0 || number >= c->info->rod_count)
    return hb_fail(err, HB_ERR_INPUT,
                   "--rod %s: the trajectory has no rod of that name or number; it has %d rods", r->rod,
                   c->info->rod_count);
  c->rod = (int)number;
  return HB_OK;
}

/* Opens the trajectory and makes room. */
static hb_status prepare(const request *r, cli_chart *c, hb_error *err) {
  hb_status status = hb_reader_open(r->path, &c->reader, err);
  if (status != HB_OK) return status;
  c->info = hb_reader_info(c->reader);
  c->err = err;
  size_t frames = (size_t)c->info->frames, nv = (size_t)c->info->nv;
  if (frames < 1) return hb_fail(err, HB_ERR_INPUT, "%s: the file holds no frame yet", r->path);
  c->times = hb_alloc(frames, sizeof *c->times);
  c->series = hb_alloc(frames, sizeof *c->series);
  c->table = hb_alloc(frames, CLI_CHART_RODS * sizeof *c->table);
  c->field = hb_alloc(nv, 4 * sizeof *c->field);
  c->points = hb_alloc(nv, 3 * sizeof *c->points);
  if (!c->times || !c->series || !c->table || !c->field || !c->points)
    return hb_fail_memory(err, "data of the charts");
  status = hb_reader_series(c->reader, "time", c->times, err);
  if (status == HB_OK) status = pick_frames(r, c, err);
  if (status == HB_OK) status = pick_rod(r, c, err);
  return status;
}

/* Size, font, colours, and the grid of panels. */
static void say_style(const request *r, cli_chart *c) {
  int columns = r->kind_count > 2 ? 2 : 1, rows = (r->kind_count + columns - 1) / columns;
  int width = r->width       ? r->width
              : columns == 2 ? 1400
                             : 900,
      height = r->height ? r->height : 440 * rows + 30;
  char title[512];
  size_t n = 0;
  for (const char *p = c->info->title; *p && n + 3 < sizeof title; p++) {
    if (*p == '\'') title[n++] = '\'';
    title[n++] = (unsigned char)*p < 32 ? ' ' : *p;
  }
  title[n] = 0;
  if (cli_ends_with(r->out, ".svg"))
    cli_chart_say(
        c, "set terminal svg size %d,%d dynamic noenhanced font 'DejaVu Sans,13' background '#fcfbf9'\n",
        width, height);
  else
    cli_chart_say(c,
                  "set terminal pngcairo size %d,%d noenhanced font 'DejaVu Sans,11' background '#fcfbf9'\n",
                  width, height);
  cli_chart_say(c, "set multiplot layout %d,%d title '%s' font ',14' textcolor rgb '#2c3039'\n", rows,
                columns, title);
  cli_chart_say(
      c, "set border 3 lc rgb '#8c877e' lw 1\nset tics nomirror out scale 0.6 textcolor rgb '#5a5750'\n"
         "set grid lc rgb '#e4e0d8' lt 1 lw 1\nset title textcolor rgb '#2c3039'\n"
         "set xlabel textcolor rgb '#5a5750' offset 0,0.4\nset ylabel textcolor rgb '#5a5750'\n"
         "set key below center horizontal Left reverse width 1 textcolor rgb '#5a5750' samplen 2 height 1.2\n"
         "set format y '%%g'\nset autoscale fix\nset rmargin 4\nset offsets 0,0,graph 0.06,graph 0.06\n");
}

/* Name beside the picture for the time of writing. */
static bool part_name(const char *out, char *text, size_t size) {
  int length = snprintf(text, size, "%s.part", out);
  return length > 0 && (size_t)length < size;
}

/* Starts gnuplot, sends every panel, puts the picture in place. */
static hb_status plot(const request *r, cli_chart *c, hb_error *err) {
  char part[TEXT_ROOM];
  const char *const argv[] = {"gnuplot", "-", NULL};
  if (!part_name(r->out, part, sizeof part))
    return hb_fail(err, HB_ERR_INPUT, "-o %s: the name is too long", r->out);
  hb_status writable = cli_try_file(part, r->out, "picture", err);
  if (writable != HB_OK) return writable;
  c->status = cli_pipe_open(&c->pipe, argv, "gnuplot-nox", part, err);
  if (c->status != HB_OK) {
    remove(part);
    return c->status;
  }
  say_style(r, c);
  for (int k = 0; k < r->kind_count && c->status == HB_OK; k++) r->kinds[k]->draw(c);
  cli_chart_say(c, "unset multiplot\n");
  cli_chart_flush(c);
  hb_status status = c->status, closing = cli_pipe_close(&c->pipe, status == HB_OK ? err : NULL);
  if (status == HB_OK) status = closing;
  if (status == HB_OK && rename(part, r->out) != 0)
    status = hb_fail(err, HB_ERR_IO, "%s: the picture cannot be put in place: %s", r->out, strerror(errno));
  if (status != HB_OK)
    remove(part);
  else
    printf("%s: %d charts of %ld frames\n", r->out, r->kind_count, c->info->frames);
  return status;
}

/* The verb. */
static int plot_verb(int argc, char **argv) {
  request r;
  hb_error err = {HB_OK, ""};
  if (cli_wants_diagram(argc, argv)) return cli_draw_diagram(argc, argv);
  int result = parse(argc, argv, &r);
  if (result >= 0) return result;
  cli_chart *c = hb_alloc(1, sizeof *c);
  hb_status status = c ? prepare(&r, c, &err) : hb_fail_memory(&err, "charts");
  if (status == HB_OK) status = plot(&r, c, &err);
  if (c) {
    hb_free(c->times);
    hb_free(c->series);
    hb_free(c->table);
    hb_free(c->field);
    hb_free(c->points);
    hb_reader_close(c->reader);
  }
  hb_free(c);
  return status == HB_OK ? CLI_DONE : cli_fail("plot", &err);
}

const cli_verb cli_verb_plot = {
    "plot", "draw curves of a trajectory",
    "usage: hebra plot TRAJECTORY [--what LIST] [-o NAME] [options]\n\n"
    "Draws charts over time and along a rod into one picture (needs gnuplot).\n\n"
    "  --what LIST         charts with commas between them; default energies,twist,length,curvature\n"
    "      over time: energies, balance, twist, length, momentum, angular_momentum, reactions, torque\n"
    "      along a rod: curvature, twist_density, tension, moment\n"
    "  -o, --output NAME   picture, .png or .svg; default plot.png\n"
    "  --frames A,B,...    frames drawn along the rod, at most 12; -1 is the last; default: five of them\n"
    "  --rod NAME          rod drawn along its length, by name or number; default: the first\n"
    "  --size WxH          size in pixels; default: from the number of charts\n\n"
    "usage: hebra plot BRANCHES.csv [--x NAME] [--y NAME] [--shapes N] [-o NAME] [--size WxH]\n\n"
    "Draws the diagram of a hebra trace with pictures of shapes beside it.\n\n"
    "  --x NAME, --y NAME  columns of the table; default parameter, amplitude\n"
    "  --shapes N          shapes beside the diagram, 0 to 12; default 6\n\n"
    "Examples:\n"
    "  hebra plot out/euler-trace/branches.csv --y end_x -o euler.png\n"
    "  hebra plot out/trajectory.h5 --what energies,length -o energies.svg\n",
    plot_verb};
