/* What files cost: reading a scene up to the first step, whole runs with output, frames written between
 * steps. */
#include "base/clock.h"
#include "base/threads.h"
#include "cli/bench.h"

#include <getopt.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

#define EVERY 10

/* A scene as a beginner writes it. */
static const char small_scene[] = "title: small\n"
                                  "method: {time_step: 1e-3, duration: 1}\n"
                                  "rods:\n"
                                  "  - name: rod\n"
                                  "    rest: {line: {from: [0, 0, 0], to: [1, 1, 0], vertices: 25}}\n"
                                  "    initial: {perturb: {vertex: 1, by: [0, 0, 0.05]}}\n"
                                  "    lengths: initial\n"
                                  "    bending: 0.1\n"
                                  "    twisting: 10\n"
                                  "    vertex_mass: 50\n"
                                  "    start: {position: fixed, material_angle: 3*pi}\n"
                                  "    end: {position: fixed, material_angle: 0}\n";

/* An empty directory for what is written. */
static hb_status make_directory(char *path, size_t size, hb_error *err) {
  const char *where = getenv("TMPDIR");
  snprintf(path, size, "%s/hebra-bench-XXXXXX", where && *where ? where : "/tmp");
  if (mkdtemp(path)) return HB_OK;
  return hb_fail(err, HB_ERR_IO, "%s: no directory can be made there; TMPDIR says where else", path);
}

/* Removes it with what a run leaves. */
static void remove_directory(const char *path) {
  const char *names[] = {"trajectory.h5", "checkpoint.hbc", "report.json"};
  char file[PATH_MAX + 32];
  for (int k = 0; k < 3; k++) {
    snprintf(file, sizeof file, "%s/%s", path, names[k]);
    unlink(file);
  }
  rmdir(path);
}

/* From text to the first step, in seconds. */
static hb_status first_step(double *seconds, hb_error *err) {
  hb_scene_def def;
  hb_model *model = NULL;
  hb_sim *sim = NULL;
  double started = hb_clock_now();
  hb_status status = hb_scene_parse(small_scene, strlen(small_scene), "small.yaml", NULL, NULL, 0, &def, err);
  if (status) return status;
  status = hb_model_create(&def, &model, err);
  if (!status) status = hb_sim_create(model, &sim, err);
  if (!status) status = hb_sim_step(sim, err);
  *seconds = hb_clock_now() - started;
  hb_sim_free(sim);
  hb_model_free(model);
  hb_scene_def_free(&def);
  return status;
}

/* The scene as a file, of one step. */
static hb_status write_scene(const char *path, hb_error *err) {
  FILE *file = fopen(path, "w");
  bool written = file && fprintf(file, "%s", small_scene) > 0;
  if (file && fclose(file) != 0) written = false;
  return written ? HB_OK : hb_fail(err, HB_ERR_IO, "%s: cannot be written", path);
}

/* This program as a process of its own, `hebra run` of one step with all it writes, in seconds. false where a
 * program cannot find itself. */
static bool whole_process(char *scene, char *directory, double *seconds) {
  char verb[] = "run", output[] = "-o", quiet[] = "--quiet", set[] = "--set", one[] = "method.duration=1e-3";
  char self[] = "/proc/self/exe";
  char *arguments[] = {self, verb, scene, output, directory, quiet, set, one, NULL};
  int ended = 1;
  double started = hb_clock_now();
  pid_t child = fork();
  if (child == 0) {
    execv(self, arguments);
    _exit(1);
  }
  bool done = child > 0 && waitpid(child, &ended, 0) == child && WIFEXITED(ended) && WEXITSTATUS(ended) == 0;
  *seconds = hb_clock_now() - started;
  return done;
}

/* One line of the group. */
static void say_start(const cli_bench_report *report, const char *what, double seconds) {
  if (report->json) {
    hb_json_object(report->json, NULL);
    hb_json_text(report->json, "what", what);
    hb_json_number(report->json, "ms", 1e3 * seconds);
    hb_json_object_end(report->json);
    return;
  }
  printf("%-54s %9.2f ms\n", what, 1e3 * seconds);
  fflush(stdout);
}

/* The verb `run` on a scene file, with all it writes: the best of a few. */
static hb_status run_scene(const cli_bench_report *report, const char *name, hb_error *err) {
  char path[PATH_MAX], directory[PATH_MAX], what[PATH_MAX];
  double best = HUGE_VAL;
  int length = snprintf(path, sizeof path, "%s/%s.yaml", report->scenes, name);
  if (length >= (int)sizeof path || access(path, R_OK) != 0) {
    fprintf(stderr,
            "hebra bench: %s/%s.yaml cannot be read and is left out; --scenes DIR says where scenes are\n",
            report->scenes, name);
    return HB_OK;
  }
  for (int trial = 0; trial < (report->quick ? 1 : 5); trial++) {
    hb_status status = make_directory(directory, sizeof directory, err);
    if (status) return status;
    char verb[] = "run", output[] = "-o", quiet[] = "--quiet";
    char *arguments[] = {verb, path, output, directory, quiet, NULL};
    optind = 1;
    double started = hb_clock_now();
    int ended = cli_verb_run.run(5, arguments);
    best = fmin(best, hb_clock_now() - started);
    remove_directory(directory);
    if (ended != CLI_DONE)
      return hb_fail(err, ended == CLI_BAD_INPUT ? HB_ERR_INPUT : HB_ERR_NUMERIC, "%s: the run failed", path);
  }
  snprintf(what, sizeof what, "whole run of %s", name);
  say_start(report, what, best);
  return HB_OK;
}

/* A small scene from the command line. */
static hb_status run_process(const cli_bench_report *report, hb_error *err) {
  char directory[PATH_MAX], scene[PATH_MAX + 32];
  double best = HUGE_VAL, seconds;
  hb_status status = make_directory(directory, sizeof directory, err);
  if (status) return status;
  snprintf(scene, sizeof scene, "%s/small.yaml", directory);
  status = write_scene(scene, err);
  for (int trial = 0; !status && trial < 10; trial++)
    if (whole_process(scene, directory, &seconds)) best = fmin(best, seconds);
  unlink(scene);
  remove_directory(directory);
  if (!status && isfinite(best))
    say_start(report, "scene of 25 vertices, process of one step with output", best);
  return status;
}

/* The group `start`. */
hb_status cli_bench_start_up(const cli_bench_report *report, hb_error *err) {
  const char *const scenes[] = {"thesis-1-twisted", "thesis-2-catenary", "thesis-3-tree"};
  double best = HUGE_VAL, seconds = 0;
  hb_status status = HB_OK;
  for (int trial = 0; !status && trial < 20; trial++) {
    status = first_step(&seconds, err);
    best = fmin(best, seconds);
  }
  if (status) return status;
  say_start(report, "scene of 25 vertices, text to first step", best);
  status = run_process(report, err);
  for (int k = 0; !status && k < 3; k++) status = run_scene(report, scenes[k], err);
  return status;
}

/* What a trial took. */
typedef struct output_cost {
  double wall;              /* seconds in all, until the system has every byte */
  double stepping, writing; /* seconds of processor, of the thread that steps and of the one that writes */
} output_cost;

/* `frames` times 10 steps, with a frame after each 10 if there is a path to write to, as `run` does it. */
static hb_status step_and_write(cli_bench_run *run, hb_frame *frame, const char *path, int frames,
                                output_cost *cost, hb_error *err) {
  hb_writer *writer = NULL;
  hb_recorder *recorder = NULL;
  hb_status status = HB_OK;
  if (path) status = hb_writer_create(path, run->model, frames, &writer, err);
  hb_record_plan plan = {.writer = writer, .frame = frame, .threaded = hb_processors() > 1};
  if (path && !status) status = hb_recorder_create(run->model, &plan, &recorder, err);
  double started = hb_clock_now(), used = hb_clock_thread();
  for (int k = 0; !status && k < frames; k++) {
    status = hb_sim_advance(run->sim, EVERY, err);
    if (!status && path) status = hb_recorder_add(recorder, run->sim, false, err);
  }
  cost->stepping = hb_clock_thread() - used;
  if (recorder && !status) status = hb_recorder_wait(recorder, err);
  cost->writing = recorder ? hb_recorder_seconds(recorder) : 0;
  cost->wall = hb_clock_now() - started;
  hb_recorder_free(recorder);
  hb_status closing = hb_writer_close(writer, status ? NULL : err); /* waits for the disk */
  return status ? status : closing;
}

/* The less of both, number by number. */
static void keep_best(output_cost *best, const output_cost *cost) {
  best->wall = fmin(best->wall, cost->wall);
  best->stepping = fmin(best->stepping, cost->stepping);
  best->writing = fmin(best->writing, cost->writing);
}

/* One line, or one object. */
static void say_output(const cli_bench_report *report, const cli_bench_case *c, const output_cost *alone,
                       const output_cost *beside, double per, double bytes) {
  double loss = beside->wall / alone->wall - 1, loss_stepping = beside->stepping / alone->stepping - 1;
  if (report->json) {
    hb_json_object(report->json, NULL);
    hb_json_integer(report->json, "rods", c->rods);
    hb_json_integer(report->json, "vertices", c->vertices);
    hb_json_integer(report->json, "every", EVERY);
    hb_json_number(report->json, "ns_per_vertex_step", alone->wall * per);
    hb_json_number(report->json, "ns_per_vertex_step_writing", beside->wall * per);
    hb_json_number(report->json, "loss", loss);
    hb_json_number(report->json, "loss_stepping", loss_stepping);
    hb_json_number(report->json, "ns_per_vertex_frame_on_writer", EVERY * beside->writing * per);
    hb_json_number(report->json, "bytes_per_frame", bytes);
    hb_json_object_end(report->json);
    return;
  }
  printf("%4d %7d %9.1f %9.1f %7.1f%% %8.1f%% %9.1f %10.1f\n", c->rods, c->vertices, alone->wall * per,
         beside->wall * per, 100 * loss, 100 * loss_stepping, EVERY * beside->writing * per, 1e-3 * bytes);
  fflush(stdout);
}

/* Steps without and with output, by turns; the best of each. */
static hb_status compare_output(const cli_bench_report *report, const cli_bench_case *c, int frames,
                                const char *directory, hb_error *err) {
  char path[PATH_MAX + 32];
  output_cost alone = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, beside = alone, cost = alone;
  long vertices = 0;
  cli_bench_run run;
  hb_frame *frame = NULL;
  struct stat about = {0};
  snprintf(path, sizeof path, "%s/trajectory.h5", directory);
  hb_status status = cli_bench_start(c, &run, err);
  run.def.output.fields = hb_field_groups[1].fields; /* standard */
  if (!status) status = hb_frame_create(run.model, &frame, err);
  for (int trial = 0; !status && trial < (report->quick ? 2 : 4); trial++) {
    status = step_and_write(&run, frame, NULL, frames, &cost, err);
    keep_best(&alone, &cost);
    if (!status) status = step_and_write(&run, frame, path, frames, &cost, err);
    keep_best(&beside, &cost);
    if (!status && stat(path, &about) != 0) status = hb_fail(err, HB_ERR_IO, "%s: is not there", path);
    unlink(path);
  }
  hb_frame_free(frame);
  cli_bench_stop(&run);
  if (status) return status;
  for (int r = 0; r < c->rods; r++) vertices += cli_bench_vertices(c, r);
  double per = 1e9 / ((double)vertices * EVERY * frames);
  say_output(report, c, &alone, &beside, per, (double)about.st_size / frames);
  return HB_OK;
}

/* The group `output`. */
hb_status cli_bench_output(const cli_bench_report *report, hb_error *err) {
  const cli_bench_case cases[] = {{.integrator = "verlet", .rods = 1, .vertices = 100},
                                  {.integrator = "verlet", .rods = 1, .vertices = 1000},
                                  {.integrator = "verlet", .rods = 1, .vertices = 10000},
                                  {.integrator = "verlet", .rods = 1000, .vertices = 50}};
  char directory[PATH_MAX];
  hb_status status = make_directory(directory, sizeof directory, err);
  if (status) return status;
  if (!report->json)
    printf("%4s %7s %9s %9s %8s %9s %9s %10s\n", "rods", "N", "ns/vertex", "writing", "loss", "stepping",
           "ns/frame", "kB/frame");
  for (int k = 0; !status && k < (report->quick ? 3 : 4); k++) {
    /* About 100 MB in all, at 500 bytes per vertex. */
    long vertices = (long)cases[k].rods * cases[k].vertices;
    int frames = 200000 / vertices > 100 ? 100 : (int)(200000 / vertices);
    status = compare_output(report, &cases[k], report->quick && frames > 10 ? 10 : frames, directory, err);
  }
  remove_directory(directory);
  return status;
}
