/* hebra export: a trajectory in the formats of other programs. */
#include "cli/cli.h"

#include "base/memory.h"
#include "output/file.h"

#include <errno.h>
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What was asked for. */
typedef struct request {
  const char *path, *formats, *directory;
  long first, last, stride;
} request;

/* One number of a:b:stride; an empty one leaves *out. Returns what follows, NULL if it is no number. */
static const char *part(const char *text, long *out) {
  if (*text == ':' || !*text) return text;
  char *end = NULL;
  errno = 0;
  long value = strtol(text, &end, 10);
  if (end == text || errno || (*end && *end != ':')) return NULL;
  *out = value;
  return end;
}

/* a, a:b or a:b:stride. */
static bool parse_frames(const char *text, request *r) {
  long *const parts[] = {&r->first, &r->last, &r->stride};
  const char *at = text;
  if (!*text) return false;
  for (int k = 0; k < 3; k++) {
    at = part(at, parts[k]);
    if (!at) return false;
    if (!*at) {
      if (k == 0) r->last = r->first;
      return true;
    }
    at++;
  }
  return false;
}

/* True for "csv", "vtp" or both with a comma. */
static bool known_formats(const char *formats) {
  const char *at = formats;
  for (;;) {
    size_t length = strcspn(at, ",");
    if (length != 3 || (strncmp(at, "csv", 3) != 0 && strncmp(at, "vtp", 3) != 0)) return false;
    at += length;
    if (!*at) return true;
    at++;
  }
}

/* The directory "export" beside the trajectory; to be freed. */
static char *default_directory(const char *path) {
  const char *slash = strrchr(path, '/');
  if (!slash) return hb_strdup("export");
  char *beside = hb_strndup(path, (size_t)(slash - path) + 1);
  char *directory = beside ? hb_file_join(beside, "export") : NULL;
  hb_free(beside);
  return directory;
}

/* Opens and writes each format in turn. */
static int export_all(const request *r) {
  hb_reader *reader = NULL;
  hb_error err;
  char *beside = default_directory(r->path);
  const char *directory = r->directory ? r->directory : beside;
  hb_status status =
      beside ? hb_reader_open(r->path, &reader, &err) : hb_fail_memory(&err, "name of a directory");
  if (status == HB_OK) {
    long frames = hb_reader_info(reader)->frames;
    long first = r->first < 0 ? r->first + frames : r->first, last = r->last < 0 ? r->last + frames : r->last;
    for (const char *at = r->formats; status == HB_OK && *at; at += at[3] ? 4 : 3) {
      char format[4] = {at[0], at[1], at[2], 0};
      status = hb_export(reader, format, directory, first, last, r->stride, &err);
      if (status == HB_OK)
        printf("%s: %ld frames in %s\n", format, (last - first) / r->stride + 1, directory);
    }
  }
  hb_reader_close(reader);
  hb_free(beside);
  return status == HB_OK ? CLI_DONE : cli_fail("export", &err);
}

/* The verb. */
static int run(int argc, char **argv) {
  static const struct option options[] = {{"format", required_argument, NULL, 'f'},
                                          {"frames", required_argument, NULL, 'n'},
                                          {"output", required_argument, NULL, 'o'},
                                          {NULL, 0, NULL, 0}};
  request r = {.first = 0, .last = -1, .stride = 1};
  opterr = 0;
  for (int key; (key = getopt_long(argc, argv, ":o:f:", options, NULL)) != -1;) {
    if (key == 'f')
      r.formats = optarg;
    else if (key == 'o')
      r.directory = optarg;
    else if (key == ':')
      return cli_usage(&cli_verb_export, "%s needs a value", argv[optind - 1]);
    else if (key != 'n')
      return cli_usage(&cli_verb_export, "unknown option %s; allowed are --format, -o and --frames",
                       argv[optind - 1]);
    else if (!parse_frames(optarg, &r))
      return cli_usage(&cli_verb_export, "--frames %s: expected FIRST, FIRST:LAST or FIRST:LAST:STRIDE",
                       optarg);
  }
  if (optind + 1 != argc)
    return cli_usage(&cli_verb_export, "expected one trajectory file, found %d arguments", argc - optind);
  if (!r.formats) return cli_usage(&cli_verb_export, "--format is missing; allowed are csv, vtp and csv,vtp");
  if (!known_formats(r.formats))
    return cli_usage(&cli_verb_export, "--format %s: allowed are csv, vtp and csv,vtp", r.formats);
  r.path = argv[optind];
  return export_all(&r);
}

const cli_verb cli_verb_export = {
    .name = "export",
    .summary = "a trajectory as csv tables or VTK files",
    .help =
        "usage: hebra export FILE --format csv,vtp [-o DIR] [--frames FIRST:LAST:STRIDE]\n"
        "\n"
        "  --format LIST   csv: scalars.csv with one row per frame, and for each rod a table with one row "
        "per\n"
        "                  frame and vertex; units stand in the header, numbers read back to the same bits\n"
        "                  vtp: one file of polylines per frame and trajectory.pvd with the times, for "
        "every\n"
        "                  ParaView (5.12 and newer open the trajectory itself)\n"
        "  -o DIR          where the files go; default: the directory export beside FILE\n"
        "  --frames RANGE  FIRST, FIRST:LAST or FIRST:LAST:STRIDE; counted from 0, negative from the end, "
        "LAST\n"
        "                  is included; default: all\n"
        "\n"
        "Example:  hebra export results/trajectory.h5 --format csv,vtp --frames 0:-1:10\n",
    .run = run};
