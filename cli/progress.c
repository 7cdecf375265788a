#include "cli/progress.h"

#include <stdio.h>
#include <time.h>
#include <unistd.h>

#define BAR_WIDTH 24

/* Wall clock in seconds. */
static double wall(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Remembers where the run starts. */
void cli_progress_begin(cli_progress *p, const hb_sim *sim, bool quiet) {
  *p = (cli_progress){
      .quiet = quiet, .terminal = isatty(STDERR_FILENO) == 1, .started = wall(), .last_tenth = -1};
  p->first_step = hb_sim_steps(sim);
  p->total_steps = hb_sim_total_steps(sim);
  p->duration = hb_sim_model(sim)->def->method.duration;
}

/* Seconds since begin. */
double cli_progress_seconds(const cli_progress *p) { return wall() - p->started; }

/* Part done, 0 .. 1. */
static double part_done(const cli_progress *p, const hb_frame *frame) {
  return p->total_steps > 0 ? (double)frame->step / (double)p->total_steps : 1;
}

/* The bar with time, rate, energy and length error. */
static void draw_bar(const cli_progress *p, const hb_frame *frame) {
  char bar[BAR_WIDTH + 1];
  double part = part_done(p, frame), seconds = wall() - p->started;
  double rate = seconds > 0 ? (double)(frame->step - p->first_step) / seconds : 0;
  double left = rate > 0 ? (double)(p->total_steps - frame->step) / rate : 0;
  for (int k = 0; k < BAR_WIDTH; k++) bar[k] = k < (int)(part * BAR_WIDTH + 0.5) ? '=' : '.';
  bar[BAR_WIDTH] = 0;
  fprintf(stderr,
          "\r[%s] %3.0f%%  t %.4g/%.4g  %.3g steps/s  energy %.5g (balance %.1e)  length %.1e  %.0f s left "
          "\033[K",
          bar, 100 * part, frame->time, p->duration, rate,
          frame->kinetic + frame->bending + frame->twisting + frame->stretching, frame->balance,
          frame->length_error, left);
  fflush(stderr);
}

/* One line per tenth of the run. */
static void print_line(cli_progress *p, const hb_frame *frame) {
  int tenth = (int)(10 * part_done(p, frame));
  if (tenth == p->last_tenth) return;
  p->last_tenth = tenth;
  fprintf(stderr,
          "%3.0f%%  t = %.6g of %.6g  step %ld  kinetic %.6g  bending %.6g  twisting %.6g  balance %.2e  "
          "length error %.2e\n",
          100 * part_done(p, frame), frame->time, p->duration, frame->step, frame->kinetic, frame->bending,
          frame->twisting, frame->balance, frame->length_error);
}

/* At most ten times a second on a terminal. */
void cli_progress_show(cli_progress *p, const hb_frame *frame) {
  if (p->quiet) return;
  if (!p->terminal) {
    print_line(p, frame);
    return;
  }
  double now = wall();
  if (now - p->shown < 0.1) return;
  p->shown = now;
  draw_bar(p, frame);
}

/* Last state and a line break. */
void cli_progress_end(cli_progress *p, const hb_frame *frame) {
  if (p->quiet) return;
  if (p->terminal) {
    draw_bar(p, frame);
    fputc('\n', stderr);
  } else {
    if (p->last_tenth < 10) p->last_tenth = -1; /* a run that ends early says where */
    print_line(p, frame);
  }
}
