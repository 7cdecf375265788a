/* hebra info: what a trajectory holds. */
#include "cli/cli.h"

#include "base/memory.h"
#include "output/json.h"
#include "output/series.h"
#include "rod/writhe.h"

#include <getopt.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

/* What is shown besides the reader's own table. */
typedef struct facts {
  const char *path;
  const hb_trajectory_info *info;
  double bytes, disk;   /* length of the file, and what of it takes room on the disk */
  uint64_t held;        /* fields */
  double *first, *last; /* every series at the first and last frame; NULL without frames */
} facts;

/* Reads every series, keeps its ends. */
static hb_status read_ends(hb_reader *reader, facts *f, hb_error *err) {
  size_t frames = (size_t)f->info->frames, count = (size_t)hb_series_count;
  if (frames == 0) return HB_OK;
  double *values = hb_alloc(frames, sizeof *values);
  f->first = hb_alloc(count, sizeof *f->first);
  f->last = hb_alloc(count, sizeof *f->last);
  hb_status status = values && f->first && f->last ? HB_OK : hb_fail_memory(err, "scalars of the trajectory");
  for (int k = 0; status == HB_OK && k < hb_series_count; k++) {
    status = hb_reader_series(reader, hb_series_table[k].name, values, err);
    if (status != HB_OK) break;
    f->first[k] = values[0];
    f->last[k] = values[frames - 1];
  }
  hb_free(values);
  return status;
}

/* For a person. */
static void print_text(const facts *f) {
  const hb_trajectory_info *info = f->info;
  printf("file       %s (%.1f MB, %.1f MB of it on the disk)\n", f->path, f->bytes / 1e6, f->disk / 1e6);
  if (info->title[0]) printf("title      %s\n", info->title);
  printf("written by hebra %s\n", info->version);
  printf("rods       %d with %d vertices in all\n", info->rod_count, info->nv);
  for (int r = 0; r < info->rod_count && r < 20; r++)
    printf("  %-20s %d vertices, radius %g%s\n", info->rods[r].name, info->rods[r].nv, info->rods[r].radius,
           info->rods[r].closed ? ", closed (the last vertex is the first)" : "");
  if (info->rod_count > 20) printf("  ... and %d more (--json lists all)\n", info->rod_count - 20);
  printf("frames     %ld\n", info->frames);
  if (f->first) {
    printf("%-24s %-24s %-24s %s\n", "", "first frame", "last frame", "unit");
    for (int k = 0; k < hb_series_count; k++)
      printf("  %-22s %-24.10g %-24.10g %s\n", hb_series_table[k].name, f->first[k], f->last[k],
             hb_series_table[k].unit);
  }
  printf("fields of every frame\n");
  for (int k = 0; k < hb_frame_field_count; k++) {
    const hb_frame_field *field = &hb_frame_fields[k];
    if (!(f->held >> k & 1)) continue;
    printf("  %-20s %d per %-7s [%s] %s\n", field->name, field->components,
           field->location == HB_ON_EDGE ? "edge" : "vertex", field->unit, field->text);
  }
}

/* Values of all series as an object. */
static void json_series(hb_json *json, const char *key, const double *values) {
  hb_json_object(json, key);
  for (int k = 0; k < hb_series_count; k++) hb_json_number(json, hb_series_table[k].name, values[k]);
  hb_json_object_end(json);
}

/* For a program. */
static void print_json(const facts *f) {
  const hb_trajectory_info *info = f->info;
  hb_json json;
  hb_json_begin(&json, stdout);
  hb_json_text(&json, "file", f->path);
  hb_json_number(&json, "bytes", f->bytes);
  hb_json_number(&json, "bytes_on_disk", f->disk);
  hb_json_text(&json, "title", info->title);
  hb_json_text(&json, "version", info->version);
  hb_json_integer(&json, "frames", info->frames);
  hb_json_integer(&json, "vertices", info->nv);
  hb_json_array(&json, "rods");
  for (int r = 0; r < info->rod_count; r++) {
    hb_json_object(&json, NULL);
    hb_json_text(&json, "name", info->rods[r].name);
    hb_json_integer(&json, "first", info->rods[r].first);
    hb_json_integer(&json, "vertices", info->rods[r].nv);
    hb_json_number(&json, "radius", info->rods[r].radius);
    hb_json_bool(&json, "closed", info->rods[r].closed);
    hb_json_object_end(&json);
  }
  hb_json_array_end(&json);
  if (f->first) {
    json_series(&json, "first_frame", f->first);
    json_series(&json, "last_frame", f->last);
  }
  hb_json_array(&json, "fields");
  for (int k = 0; k < hb_frame_field_count; k++) {
    const hb_frame_field *field = &hb_frame_fields[k];
    if (!(f->held >> k & 1)) continue;
    hb_json_object(&json, NULL);
    hb_json_text(&json, "name", field->name);
    hb_json_integer(&json, "components", field->components);
    hb_json_text(&json, "location", field->location == HB_ON_EDGE ? "edge" : "vertex");
    hb_json_text(&json, "unit", field->unit);
    hb_json_text(&json, "text", field->text);
    hb_json_object_end(&json);
  }
  hb_json_array_end(&json);
  hb_json_text(&json, "source", info->source);
  hb_json_end(&json);
}

/* Link, twist and writhe of one closed rod at one frame. */
static void rod_link(const hb_reader_rod *rod, const double *position, const double *twist, double link[3]) {
  const double pi = 3.14159265358979323846;
  link[1] = 0;
  for (int i = 1; i < rod->nv; i++) link[1] += twist[rod->first + i] / (2 * pi);
  link[2] = hb_rod_writhe(position + 3 * (size_t)rod->first, rod->nv - 1, true);
  link[0] = link[1] + link[2];
}

/* A line for every frame and closed rod. */
static hb_status print_links(hb_reader *reader, bool as_json, hb_error *err) {
  const hb_trajectory_info *info = hb_reader_info(reader);
  size_t nv = (size_t)info->nv, frames = (size_t)info->frames;
  double *position = hb_alloc(3 * nv, sizeof *position), *twist = hb_alloc(nv, sizeof *twist),
         *time = hb_alloc(frames, sizeof *time);
  hb_status status = position && twist && time ? HB_OK : hb_fail_memory(err, "a frame of the trajectory");
  if (!status && frames > 0) status = hb_reader_series(reader, "time", time, err);
  hb_json json;
  if (as_json && !status) {
    hb_json_begin(&json, stdout);
    hb_json_array(&json, "links");
  } else if (!status) {
    printf("%-14s %-20s %-20s %-20s %s\n", "time", "rod", "linking_number", "twist", "writhe");
  }
  for (size_t n = 0; !status && n < frames; n++) {
    status = hb_reader_field(reader, "position", (long)n, position, err);
    if (!status) status = hb_reader_field(reader, "twist", (long)n, twist, err);
    for (int r = 0; !status && r < info->rod_count; r++) {
      double link[3];
      if (!info->rods[r].closed) continue;
      rod_link(&info->rods[r], position, twist, link);
      if (!as_json) {
        printf("%-14.9g %-20s %-20.14g %-20.14g %.14g\n", time[n], info->rods[r].name, link[0], link[1],
               link[2]);
        continue;
      }
      hb_json_object(&json, NULL);
      hb_json_number(&json, "time", time[n]);
      hb_json_text(&json, "rod", info->rods[r].name);
      hb_json_number(&json, "linking_number", link[0]);
      hb_json_number(&json, "twist", link[1]);
      hb_json_number(&json, "writhe", link[2]);
      hb_json_object_end(&json);
    }
  }
  if (as_json && !status) {
    hb_json_array_end(&json);
    hb_json_end(&json);
  }
  hb_free(position);
  hb_free(twist);
  hb_free(time);
  return status;
}

/* Opens, collects, prints. */
static int show(const char *path, bool json, bool links) {
  hb_reader *reader = NULL;
  hb_error err;
  facts f = {.path = path};
  struct stat size;
  hb_status status = hb_reader_open(path, &reader, &err);
  if (status == HB_OK && links) {
    status = print_links(reader, json, &err);
    hb_reader_close(reader);
    return status == HB_OK ? CLI_DONE : cli_fail("info", &err);
  }
  if (status == HB_OK) {
    f.info = hb_reader_info(reader);
    f.held = hb_reader_fields(reader);
    status = read_ends(reader, &f, &err);
  }
  if (status == HB_OK && stat(path, &size) == 0) {
    f.bytes = (double)size.st_size;
    f.disk = 512.0 * (double)size.st_blocks;
  }
  if (status == HB_OK && json) print_json(&f);
  if (status == HB_OK && !json) print_text(&f);
  hb_free(f.first);
  hb_free(f.last);
  hb_reader_close(reader);
  return status == HB_OK ? CLI_DONE : cli_fail("info", &err);
}

/* The verb. */
static int run(int argc, char **argv) {
  static const struct option options[] = {
      {"json", no_argument, NULL, 'j'}, {"link", no_argument, NULL, 'l'}, {NULL, 0, NULL, 0}};
  bool json = false, links = false;
  opterr = 0;
  for (int key; (key = getopt_long(argc, argv, "", options, NULL)) != -1;) {
    if (key != 'j' && key != 'l')
      return cli_usage(&cli_verb_info, "unknown option %s; allowed are --json and --link", argv[optind - 1]);
    json = json || key == 'j';
    links = links || key == 'l';
  }
  if (optind + 1 != argc)
    return cli_usage(&cli_verb_info, "expected one trajectory file, found %d arguments", argc - optind);
  return show(argv[optind], json, links);
}

const cli_verb cli_verb_info = {.name = "info",
                                .summary = "what a trajectory holds",
                                .help = "usage: hebra info FILE [--json] [--link]\n"
                                        "\n"
                                        "Says what the trajectory FILE holds: title, rods, frames, all "
                                        "scalars at the first and the last frame,\n"
                                        "and the fields that every frame has, with their units. The run may "
                                        "still be going on, or may have been\n"
                                        "killed: every frame that was written is there.\n"
                                        "\n"
                                        "  --json   the same for programs, with the text of the scene\n"
                                        "  --link   linking number, twist (in turns) and writhe of every "
                                        "closed rod at every frame\n"
                                        "\n"
                                        "Example:  hebra info results/trajectory.h5\n",
                                .run = run};
