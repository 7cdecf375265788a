/* From a scene to its equilibrium. */
#include "cli/solution.h"

#include "base/clock.h"
#include "base/memory.h"

#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Load steps, or iterations, that can be asked for. */
enum { MOST = 1000000 };

/* What a user means who says nothing. */
void cli_solution_begin(cli_solution *s, const cli_verb *verb) {
  memset(s, 0, sizeof *s);
  s->verb = verb;
  s->time = s->tolerance = -1;
  s->load_steps = 1;
  hb_scene_def_init(&s->def);
  opterr = 0;
  optind = 1;
}

/* One option with a value; an exit status, or -1 to go on. */
static int take(cli_solution *s, int c, const char *value) {
  switch (c) {
  case 's': return cli_override(s->verb, &s->set, value);
  case 't':
    return cli_number(value, 0, &s->time)
               ? -1
               : cli_usage(s->verb, "--time \"%s\" is not a time from 0 on", value);
  case 'T':
    return cli_number(value, 1e-15, &s->tolerance)
               ? -1
               : cli_usage(s->verb, "--tolerance \"%s\" is not a number above 1e-15", value);
  case 'l':
    return cli_whole(value, MOST, &s->load_steps)
               ? -1
               : cli_usage(s->verb, "--load-steps \"%s\" is not a whole number from 1 to 1000000", value);
  default:
    return cli_whole(value, MOST, &s->iterations)
               ? -1
               : cli_usage(s->verb, "--max-iterations \"%s\" is not a whole number from 1 to 1000000", value);
  }
}

/* Those without a value, and what is no option at all. */
int cli_solution_option(cli_solution *s, int c, const char *value, char **argv) {
  switch (c) {
  case 'o': s->output = value; return -1;
  case 'f': s->from = value; return -1;
  case 'a': s->any = true; return -1;
  case 'q': s->quiet = true; return -1;
  case 'j': s->json = true; return -1;
  case ':': return cli_usage(s->verb, "%s needs a value", argv[optind - 1]);
  case '?': return cli_usage(s->verb, "%s is not an option", argv[optind - 1]);
  default: return take(s, c, value);
  }
}

/* Where getopt stopped there must be one more argument. */
int cli_solution_scene(cli_solution *s, int argc, char **argv) {
  if (optind == argc) return cli_usage(s->verb, "the scene file is missing");
  s->scene = argv[optind++];
  if (optind < argc)
    return cli_usage(s->verb, "\"%s\": only one scene can be solved at a time", argv[optind]);
  return -1;
}

/* Reads one frame of a trajectory of the same rods; the last, or the one after a colon: FILE:FRAME. */
static hb_status read_moment(cli_solution *r, hb_error *err) {
  static const char *const names[] = {"position", "m1", "twist", "bishop_u", "theta"};
  double *const fields[] = {r->frame->position, r->frame->m1, r->frame->twist, r->frame->bishop_u,
                            r->frame->theta};
  char path[PATH_MAX];
  const char *colon = strrchr(r->from, ':');
  char *end = NULL;
  long index = colon ? strtol(colon + 1, &end, 10) : -1;
  bool chosen = colon && end != colon + 1 && !*end;
  hb_reader *reader = NULL;
  snprintf(path, sizeof path, "%.*s", chosen ? (int)(colon - r->from) : PATH_MAX - 1, r->from);
  hb_status status = hb_reader_open(path, &reader, err);
  if (status) return status;
  const hb_trajectory_info *info = hb_reader_info(reader);
  if (!chosen || index < 0) index = info->frames + (chosen ? index : -1);
  if (info->nv != r->model->nv || info->rod_count != r->model->rod_count)
    status = hb_fail(err, HB_ERR_INPUT, "%s: holds %d rods with %d vertices in all, the scene has %d with %d",
                     path, info->rod_count, info->nv, r->model->rod_count, r->model->nv);
  else if (index < 0 || index >= info->frames)
    status = hb_fail(err, HB_ERR_INPUT, "--from %s: there is no such frame; the trajectory has %ld, 0 to %ld",
                     r->from, info->frames, info->frames - 1);
  double *times = status ? NULL : hb_alloc((size_t)info->frames, sizeof *times);
  if (!status && !times) status = hb_fail_memory(err, "times of a trajectory");
  if (!status) status = hb_reader_series(reader, "time", times, err);
  for (size_t k = 0; !status && k < sizeof names / sizeof names[0]; k++)
    status = hb_reader_field(reader, names[k], index, fields[k], err);
  if (!status) r->frame->time = times[index];
  hb_free(times);
  hb_reader_close(reader);
  return status ? status : hb_sim_resume(r->sim, r->frame, err);
}

/* Scene, model, start. */
static hb_status prepare(cli_solution *s, const char *suffix, hb_error *err) {
  hb_status status = cli_directory(s->output, s->scene, suffix, s->directory, sizeof s->directory, err);
  if (!status) status = hb_scene_read(s->scene, s->set.items, s->set.count, &s->def, err);
  if (!status) status = hb_model_create(&s->def, &s->model, err);
  if (!status) status = hb_sim_create(s->model, &s->sim, err);
  if (!status) status = hb_frame_create(s->model, &s->frame, err);
  return !status && s->from ? read_moment(s, err) : status;
}

/* The search. */
hb_status cli_solution_find(cli_solution *s, const char *suffix, hb_error *err) {
  hb_status status = prepare(s, suffix, err);
  if (status) return status;
  hb_equilibrium_options how = hb_equilibrium_defaults(s->time < 0 ? s->def.method.duration : s->time);
  how.load_steps = s->load_steps;
  how.any = s->any;
  if (s->iterations > 0) how.max_iterations = s->iterations;
  if (s->tolerance > 0) how.tolerance = s->tolerance;
  double started = hb_clock_now();
  status = hb_sim_find_equilibrium(s->sim, &how, &s->found, err);
  s->seconds = hb_clock_now() - started;
  if (!status) hb_sim_measure_equilibrium(s->sim, &s->found, s->frame);
  return status;
}

/* What a person wants to know. */
void cli_solution_say(const cli_solution *s) {
  const hb_equilibrium *e = &s->found;
  fprintf(stderr, "%s\n", s->def.title ? s->def.title : "untitled scene");
  for (int k = 0; k < s->model->note_count; k++) fprintf(stderr, "note: %s\n", s->model->notes[k]);
  if (e->unstable > 0)
    fprintf(stderr, "unstable equilibrium, %d unstable mode%s", e->unstable, e->unstable > 1 ? "s" : "");
  else
    fprintf(stderr, "stable equilibrium");
  if (e->neutral > 0) fprintf(stderr, ", %d mode%s without stiffness", e->neutral, e->neutral > 1 ? "s" : "");
  fprintf(stderr, " at t = %.9g: %d iterations, %.3g s, unbalanced force %.2g of %.3g\n", s->frame->time,
          e->iterations, s->seconds, e->residual, e->force_scale);
  if (e->escapes > 0)
    fprintf(stderr, "%d unstable equilibri%s left on the way (--any stops at the first)\n", e->escapes,
            e->escapes > 1 ? "a" : "um");
}

/* A trajectory of one frame. */
hb_status cli_solution_write(const cli_solution *s, const char *path, hb_error *err) {
  hb_writer *writer = NULL;
  hb_status status = hb_writer_create(path, s->model, 1, &writer, err);
  if (!status) status = hb_writer_add(writer, s->frame, err);
  hb_status closing = hb_writer_close(writer, status ? NULL : err);
  return status ? status : closing;
}

/* Also after failures. */
void cli_solution_end(cli_solution *s) {
  hb_equilibrium_free(&s->found);
  hb_frame_free(s->frame);
  hb_sim_free(s->sim);
  hb_model_free(s->model);
  hb_scene_def_free(&s->def);
}
