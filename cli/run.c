/* hebra run: simulate a scene, or go on from a checkpoint. */
#include "base/clock.h"
#include "base/memory.h"
#include "base/threads.h"
#include "cli/advice.h"
#include "cli/cli.h"
#include "cli/links.h"
#include "cli/progress.h"
#include "cli/watch.h"
#include "output/file.h"
#include "output/report.h"

#include <errno.h>
#include <float.h>
#include <getopt.h>
#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

/* Steps between two looks at the signals. */
#define SIGNAL_STEPS 64
#define TIMED_STEPS 16
#define MOST_NOTES 20

/* The arguments. */
typedef struct options {
  const char *scene, *restart, *directory, *watch;
  cli_overrides set;
  double speed;
  int threads; /* 0: not given */
  bool quiet, json;
} options;

/* Everything that a run owns. */
typedef struct run {
  options opt;
  char directory[PATH_MAX], trajectory[PATH_MAX + 32], checkpoint[PATH_MAX + 32], report[PATH_MAX + 32];
  hb_scene_def def;
  hb_checkpoint saved;
  hb_model *model;
  hb_sim *sim;
  hb_frame *start, *frame;
  hb_writer *writer;
  hb_recorder *recorder; /* between its creation and finish, writer and frame are its own */
  cli_watch *watch;
  cli_progress progress;
  cli_links links; /* if the scene asks for them */
  long frames;
  double largest_energy; /* in any frame so far */
  double stepping;       /* seconds of processor of the thread that steps */
} run;

/* Parses argv; an exit status, or -1 to go on. */
static int parse(int argc, char **argv, options *opt) {
  static const struct option longs[] = {{"output", required_argument, NULL, 'o'},
                                        {"set", required_argument, NULL, 's'},
                                        {"restart", required_argument, NULL, 'r'},
                                        {"watch", optional_argument, NULL, 'w'},
                                        {"speed", required_argument, NULL, 'p'},
                                        {"quiet", no_argument, NULL, 'q'},
                                        {"json", no_argument, NULL, 'j'},
                                        {"threads", required_argument, NULL, 't'},
                                        {NULL, 0, NULL, 0}};
  *opt = (options){0};
  opterr = 0;
  for (int c; (c = getopt_long(argc, argv, ":o:q", longs, NULL)) != -1;) {
    switch (c) {
    case 'o': opt->directory = optarg; break;
    case 's':
      if (cli_override(&cli_verb_run, &opt->set, optarg) >= 0) return CLI_BAD_INPUT;
      break;
    case 'r': opt->restart = optarg; break;
    case 'w': opt->watch = optarg ? optarg : "terminal"; break;
    case 'p':
      if (!cli_number(optarg, DBL_MIN, &opt->speed))
        return cli_usage(&cli_verb_run, "--speed \"%s\" is not a number above 0", optarg);
      break;
    case 't':
      if (!cli_whole(optarg, HB_THREADS_MAX, &opt->threads))
        return cli_usage(&cli_verb_run, "--threads \"%s\" is not a whole number from 1 to %d", optarg,
                         HB_THREADS_MAX);
      break;
    case 'q': opt->quiet = true; break;
    case 'j': opt->json = true; break;
    case ':': return cli_usage(&cli_verb_run, "%s needs a value", argv[optind - 1]);
    default: return cli_usage(&cli_verb_run, "%s is not an option", argv[optind - 1]);
    }
  }
  if (optind < argc) opt->scene = argv[optind++];
  if (optind < argc)
    return cli_usage(&cli_verb_run, "\"%s\": only one scene can be run at a time", argv[optind]);
  if (!opt->scene == !opt->restart)
    return cli_usage(&cli_verb_run, "give either a scene file or --restart with a checkpoint");
  for (int k = 0; opt->restart && k < opt->set.count; k++)
    if (strncmp(opt->set.items[k], "method.duration=", strlen("method.duration=")) != 0)
      return cli_usage(
          &cli_verb_run,
          "--restart goes on with the scene as it was; --set %s cannot change it, only method.duration can "
          "be set to make the run longer",
          opt->set.items[k]);
  return -1;
}

/* Directory of results: as asked for, beside the checkpoint, or out/NAME after the scene file. */
static hb_status choose_directory(run *r, hb_error *err) {
  const char *asked = r->opt.directory, *scene = r->opt.scene ? r->opt.scene : r->opt.restart;
  char beside[PATH_MAX];
  if (!asked && !r->opt.scene) {
    const char *slash = strrchr(scene, '/');
    snprintf(beside, sizeof beside, "%.*s", slash ? (int)(slash - scene) : 1, slash ? scene : ".");
    asked = beside;
  }
  hb_status status = cli_directory(asked, scene, "", r->directory, sizeof r->directory, err);
  if (status) return status;
  snprintf(r->trajectory, sizeof r->trajectory, "%s/trajectory.h5", r->directory);
  snprintf(r->checkpoint, sizeof r->checkpoint, "%s/checkpoint.hbc", r->directory);
  snprintf(r->report, sizeof r->report, "%s/report.json", r->directory);
  return HB_OK;
}

/* A restarted scene still belongs to the directory of its scene file, not to that of the checkpoint. */
static hb_status keep_base(run *r, hb_error *err) {
  const char *base = r->saved.base_dir ? r->saved.base_dir : ".";
  size_t size = strlen(base) + sizeof "/scene";
  char *path = hb_alloc(size, 1);
  if (!path) return hb_fail_memory(err, "path of the scene");
  snprintf(path, size, "%s/scene", base);
  hb_free(r->def.path);
  r->def.path = path;
  return HB_OK;
}

/* Scene from its file, or from inside a checkpoint. */
static hb_status read_scene(run *r, hb_error *err) {
  if (r->opt.scene) return hb_scene_read(r->opt.scene, r->opt.set.items, r->opt.set.count, &r->def, err);
  struct stat about;
  if (stat(r->opt.restart, &about) == 0 && S_ISDIR(about.st_mode))
    return hb_fail(err, HB_ERR_INPUT,
                   "%s: is a directory; --restart wants the checkpoint in it, %s/checkpoint.hbc",
                   r->opt.restart, r->opt.restart);
  hb_status status = hb_checkpoint_read(r->opt.restart, &r->saved, err);
  if (status) return status;
  if (!r->saved.source)
    return hb_fail(err, HB_ERR_INPUT, "%s: the checkpoint holds no scene to go on with", r->opt.restart);
  status = hb_scene_parse(r->saved.source, strlen(r->saved.source), r->opt.restart, r->saved.base_dir,
                          r->opt.set.items, r->opt.set.count, &r->def, err);
  if (status) return status;
  r->def.run = r->saved.run; /* also a longer run is still the same run */
  return keep_base(r, err);
}

/* Sentences that a user should see before the run. */
static void say_notes(const run *r) {
  double moved = hb_sim_initial_correction(r->sim);
  char text[HB_REPORT_SENTENCE];
  if (r->opt.quiet) return;
  fprintf(stderr, "%s\n", r->def.title ? r->def.title : "untitled scene");
  if (hb_report_step_warning(r->model, text)) fprintf(stderr, "warning: %s\n", text);
  int told = r->model->note_count < MOST_NOTES ? r->model->note_count : MOST_NOTES;
  for (int k = 0; k < told; k++) fprintf(stderr, "note: %s\n", r->model->notes[k]);
  if (told < r->model->note_count)
    fprintf(stderr, "note: %d notes more (hebra check --json lists all)\n", r->model->note_count - told);
  if (moved > 1e-6 * r->model->rods[0].length)
    fprintf(stderr,
            "note: the initial shape was moved by up to %.3g so that every edge has its rest length\n",
            moved);
}

/* Puts the saved state back; the run may have been made longer, but not shorter than it is. */
static hb_status restore(run *r, hb_error *err) {
  hb_status status = hb_sim_restore(r->sim, r->saved.block, r->saved.count, err);
  if (status) return status;
  long done = hb_sim_steps(r->sim), total = hb_sim_total_steps(r->sim),
       regular = 1 + done / r->def.output.every;
  if (r->opt.set.count > 0 && total < done)
    return hb_fail(err, HB_ERR_INPUT, "%s: the run is at t = %.9g already, so method.duration cannot be %.9g",
                   r->opt.restart, hb_sim_time(r->sim), r->def.method.duration);
  if (access(r->trajectory, F_OK) != 0)
    return hb_fail(err, HB_ERR_INPUT,
                   "%s: is not there; to go on, the output directory must hold the trajectory of the "
                   "run that wrote the checkpoint",
                   r->trajectory);
  r->frames = r->saved.frames;
  /* The last frame of a finished run may lie between the regular ones; a longer run would not have it. */
  if (total > done && r->frames > regular) r->frames = regular;
  return HB_OK;
}

/* Keeps the largest energy that a frame has shown. */
static void note_energy(run *r, const hb_frame *frame) {
  double energy = frame->kinetic + frame->bending + frame->twisting + frame->stretching;
  if (energy > r->largest_energy) r->largest_energy = energy;
}

/* A frame has been written: shown to whoever looks. May be called by the thread that writes. */
static void see_frame(void *context, const hb_frame *frame) {
  run *r = context;
  note_energy(r, frame);
  cli_progress_show(&r->progress, frame);
  if (r->watch) cli_watch_show(r->watch, frame);
  if (r->links.model) cli_links_look(&r->links, frame);
}

/* A new trajectory takes the place of what another run left in the directory: the old checkpoint and report
 * go once it is there, and a checkpoint of the beginning follows the first frame. */
static hb_status begin_files(run *r, long planned, hb_error *err) {
  hb_status status = hb_writer_create(r->trajectory, r->model, planned, &r->writer, err);
  if (status) return status;
  const char *old[] = {r->checkpoint, r->report};
  for (int k = 0; k < 2; k++)
    if (unlink(old[k]) != 0 && errno != ENOENT)
      return hb_fail(err, HB_ERR_IO, "%s: what an older run left cannot be removed: %s", old[k],
                     strerror(errno));
  status = hb_writer_add(r->writer, r->frame, err);
  r->frames = 1;
  return status ? status : hb_checkpoint_write(r->checkpoint, r->sim, r->frames, err);
}

/* From here on frames are written beside the run, if there is a processor for it. A run that is watched goes
 * no faster than what is shown. */
static hb_status begin_recording(run *r, hb_error *err) {
  hb_record_plan plan = {
      .writer = r->writer,
      .frame = r->frame,
      .frames = r->frames,
      .checkpoint = r->checkpoint,
      .checkpoint_seconds = r->def.output.checkpoint_seconds,
      .threaded = !r->watch && hb_processors() > 1,
      .fields = (r->watch ? HB_FIELD_BIT(position) | HB_FIELD_BIT(m1) : 0) |
                (r->links.model ? HB_FIELD_BIT(position) | HB_FIELD_BIT(m1) | HB_FIELD_BIT(twist) : 0),
      .seen = see_frame,
      .context = r};
  return hb_recorder_create(r->model, &plan, &r->recorder, err);
}

/* Model, simulation, files. Nothing is written before the scene has proved sound. */
static hb_status prepare(run *r, hb_error *err) {
  hb_status status = choose_directory(r, err);
  if (!status) status = read_scene(r, err);
  if (!status) r->def.method.lanes = cli_lanes();
  r->def.method.threads = r->opt.threads;
  if (!r->def.output.fields) r->def.output.fields = hb_field_groups[1].fields; /* not said: standard */
  if (!status) status = hb_model_create(&r->def, &r->model, err);
  if (!status) status = hb_sim_create(r->model, &r->sim, err);
  if (!status) status = hb_frame_create(r->model, &r->start, err);
  if (!status) status = hb_frame_create(r->model, &r->frame, err);
  if (status) return status;
  hb_sim_measure(r->sim, r->start);
  if (r->opt.restart) status = restore(r, err);
  if (!status) status = hb_file_directory(r->directory, err);
  if (status) return status;
  long steps = hb_sim_total_steps(r->sim), every = r->def.output.every,
       planned = 1 + (steps + every - 1) / every;
  hb_sim_measure(r->sim, r->frame);
  note_energy(r, r->frame);
  hb_sim_time_stages(r->sim, TIMED_STEPS);
  if (r->opt.restart) {
    status = hb_writer_continue(r->trajectory, r->model, planned, r->frames, &r->writer, err);
  } else {
    status = begin_files(r, planned, err);
  }
  if (!status && r->opt.watch) status = cli_watch_open(r->model, r->opt.watch, r->opt.speed, &r->watch, err);
  if (!status && r->def.output.link) {
    status = cli_links_begin(&r->links, r->model, err);
    if (!status) cli_links_look(&r->links, r->frame);
  }
  return status ? status : begin_recording(r, err);
}

/* Ctrl-C and the polite kill wait here instead of ending the program; asked for between steps. */
static void block_signals(sigset_t *old) {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  sigprocmask(SIG_BLOCK, &set, old);
}

/* Has somebody asked to stop? */
static bool asked_to_stop(void) {
  sigset_t pending;
  sigpending(&pending);
  return sigismember(&pending, SIGINT) == 1 || sigismember(&pending, SIGTERM) == 1;
}

/* Takes the signals that were waiting, so that they do not end the program afterwards. */
static void drain_signals(const sigset_t *old) {
  sigset_t set;
  struct timespec none = {0, 0};
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  while (sigtimedwait(&set, NULL, &none) > 0) {
  }
  sigprocmask(SIG_SETMASK, old, NULL);
}

/* Steps until the end, a signal, or trouble. */
static hb_status step_through(run *r, hb_error *err) {
  long total = hb_sim_total_steps(r->sim), every = r->def.output.every;
  if (hb_sim_steps(r->sim) >= total) return hb_recorder_checkpoint(r->recorder, r->sim, err);
  for (long n = hb_sim_steps(r->sim); n < total;) {
    long to_frame = every - n % every, to_look = SIGNAL_STEPS - n % SIGNAL_STEPS;
    long next = n + (to_frame < to_look ? to_frame : to_look);
    if (next > total) next = total;
    hb_status status = hb_sim_advance(r->sim, next - n, err);
    if (status) return status;
    n = next;
    bool frame = n % every == 0 || n == total, look = frame || n % SIGNAL_STEPS == 0;
    if (frame) status = hb_recorder_add(r->recorder, r->sim, n == total, err);
    if (look && !status) status = hb_recorder_check(r->recorder, err);
    if (status) return status;
    if (look && n < total && asked_to_stop()) {
      status = hb_recorder_checkpoint(r->recorder, r->sim, err);
      return status ? status
                    : hb_fail(err, HB_ERR_INTERRUPTED,
                              "stopped on request at t = %.9g; hebra run --restart %s goes on from there",
                              hb_sim_time(r->sim), r->checkpoint);
    }
  }
  return HB_OK;
}

/* The run, with everything written. What could not be written comes first: the run was past it already when
 * something else ended it. */
static hb_status simulate(run *r, hb_error *err) {
  hb_error writing = {HB_OK, ""};
  double begun = hb_clock_thread();
  hb_status status = step_through(r, err);
  r->stepping = hb_clock_thread() - begun;
  if (hb_recorder_wait(r->recorder, &writing)) {
    *err = writing;
    status = writing.status;
  }
  r->frames = hb_recorder_frames(r->recorder);
  hb_recorder_complete(r->recorder);
  if (!status && r->links.status) {
    *err = r->links.err;
    status = r->links.status;
  }
  return status;
}

/* Report, closing lines, exit status. */
static int finish(run *r, hb_status status, hb_error *err) {
  struct rusage usage;
  char text[HB_REPORT_SENTENCE];
  hb_error later = {HB_OK, ""};
  getrusage(RUSAGE_SELF, &usage);
  cli_progress_end(&r->progress, r->frame);
  hb_status closing = hb_writer_close(r->writer, &later);
  r->writer = NULL;
  hb_report_facts facts = {.wall_seconds = cli_progress_seconds(&r->progress),
                           .stepping_seconds = r->stepping,
                           .writing_seconds = hb_recorder_seconds(r->recorder),
                           .peak_bytes = (size_t)usage.ru_maxrss * 1024,
                           .link_frames = r->links.frames,
                           .link_error = r->links.error,
                           .link_jumps = r->links.jumps,
                           .stop_reason = status ? err->text : "finished",
                           .largest_energy = r->largest_energy};
  hb_status reporting =
      hb_report_write(r->report, r->sim, r->start, r->frame, &facts, closing ? NULL : &later);
  if (!status && (closing || reporting)) {
    status = later.status;
    *err = later;
  }
  if (r->opt.json) cli_print_file(r->report);
  if (!r->opt.quiet)
    fprintf(stderr, "%ld frames in %s, figures in %s, %.2f s\n", r->frames, r->trajectory, r->report,
            cli_progress_seconds(&r->progress));
  if (!r->opt.quiet && r->links.frames > 0)
    fprintf(stderr, "link: twist + writhe closes to %.1e in %ld frames, jumped %ld times\n", r->links.error,
            r->links.frames, r->links.jumps);
  hb_report_books(r->model, r->start, r->frame, r->largest_energy, text);
  if (!r->opt.quiet) fprintf(stderr, "%s\n", text);
  if (!r->opt.quiet && hb_report_books_warning(r->model, r->start, r->frame, r->largest_energy, text))
    fprintf(stderr, "warning: %s\n", text);
  if (!status) return CLI_DONE;
  if (status == HB_ERR_NUMERIC) {
    cli_advice(r->sim);
    fprintf(stderr, "hebra run: the run went wrong; the last good frame is at t = %.9g in %s\n",
            r->frame->time, r->trajectory);
  }
  return cli_fail("run", err);
}

/* Frees what the run owns. */
static void release(run *r) {
  hb_recorder_free(r->recorder);
  if (r->watch) cli_watch_close(r->watch);
  cli_links_free(&r->links);
  (void)hb_writer_close(r->writer, NULL);
  hb_frame_free(r->frame);
  hb_frame_free(r->start);
  hb_sim_free(r->sim);
  hb_model_free(r->model);
  hb_scene_def_free(&r->def);
  hb_checkpoint_free(&r->saved);
}

/* The verb. */
static int run_verb(int argc, char **argv) {
  run r;
  hb_error err = {HB_OK, ""};
  sigset_t old;
  memset(&r, 0, sizeof r);
  hb_scene_def_init(&r.def);
  int result = parse(argc, argv, &r.opt);
  if (result >= 0) return result;
  hb_status status = prepare(&r, &err);
  if (status) {
    result = cli_fail("run", &err);
  } else {
    say_notes(&r);
    cli_progress_begin(&r.progress, r.sim, r.opt.quiet || r.opt.watch != NULL);
    block_signals(&old);
    status = simulate(&r, &err);
    drain_signals(&old);
    result = finish(&r, status, &err);
  }
  release(&r);
  return result;
}

const cli_verb cli_verb_run = {
    "run", "simulate a scene",
    "usage: hebra run SCENE [-o DIR] [--set KEY=VALUE ...] [--watch[=terminal|window] [--speed X]]\n"
    "                 [--threads N] [--quiet] [--json]\n"
    "       hebra run --restart DIR/checkpoint.hbc [-o DIR] [--set method.duration=T] [--threads N]\n"
    "\n"
    "Simulates a scene file and leaves in DIR (default: out/NAME of the scene)\n"
    "  trajectory.h5    every frame, for hebra render, plot, export, for ParaView and Python\n"
    "  checkpoint.hbc   the last state, for --restart\n"
    "  report.json      parameters, energies and their balance, momentum, length error, twist, timings, "
    "memory\n"
    "\n"
    "  -o, --output DIR      where the results go\n"
    "  --set KEY=VALUE       change or add a key of the scene, e.g. --set method.time_step=1e-4\n"
    "                        or --set rods.rope.bending=2 (may be given up to 64 times)\n"
    "  --restart FILE        go on from a checkpoint; the result is the same to the last bit. With\n"
    "                        --set method.duration=T the run becomes longer, also one that was finished\n"
    "  --watch[=MODE]        draw the three views while it runs: terminal (default) or window\n"
    "  --speed X             with --watch: simulated seconds per second of watching\n"
    "  --threads N           threads for the steps (default: as many as the scene is worth); the result is "
    "the "
    "same\n"
    "                        for any number\n"
    "  -q, --quiet           no progress, no notes\n"
    "  --json                print report.json to standard output at the end\n"
    "\n"
    "Ctrl-C finishes the step, writes a checkpoint and says how to go on.\n"
    "\n"
    "example: hebra run scenes/thesis-2-catenary.yaml -o out/catenary --set method.duration=1\n",
    run_verb};
