/* Live view. */
#include "cli/watch.h"

#include "cli/cast.h"
#include "cli/dots.h"
#include "cli/pipe.h"

#include "base/clock.h"
#include "base/memory.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

/* Pictures per second at most, and the size of a window. */
#define RATE 15.0
enum { WINDOW_WIDTH = 960, WINDOW_HEIGHT = 540 };

struct cli_watch {
  const hb_model *model;
  cli_cast cast;
  hb_views views;
  bool window, broken; /* broken: the window was closed, or the terminal does not take any more */
  double speed, started, start_time, shown, cost; /* cost: seconds that the last picture took */
  bool timed;                                     /* started and start_time are set */
  hb_image image;                                 /* the window's picture, or one panel in dots */
  cli_pipe pipe;
  cli_dots dots;
  int rows, columns; /* of the terminal */
  int lines;         /* that the last picture took */
  char *text;        /* a picture's characters */
  size_t room;
};

/* Lines of text around the panels in the terminal. */
enum { HEAD_LINES = 2, TITLE_LINES = 1 };

/* A little room around the shapes seen so far, so that the views do not jump at every frame. */
static void frame_views(cli_watch *w) {
  hb_views *v = &w->views;
  double size = 0;
  for (int k = 0; k < 3; k++) size = fmax(size, v->hi[k] - v->lo[k]);
  if (!(size < 1e100)) return;
  for (int k = 0; k < 3; k++) {
    v->lo[k] -= 0.1 * size;
    v->hi[k] += 0.1 * size;
  }
  double *range[2] = {v->along_range, v->across_range};
  for (int k = 0; k < 2; k++) {
    range[k][0] -= 0.1 * size;
    range[k][1] += 0.1 * size;
  }
}

/* Grows the views where a frame leaves them. */
static void follow(cli_watch *w) {
  hb_views now;
  hb_views_start(&now);
  hb_views_add(&now, w->cast.tubes, w->cast.count);
  memcpy(now.along, w->views.along, sizeof now.along);
  memcpy(now.across, w->views.across, sizeof now.across);
  hb_views_measure(&now, w->cast.tubes, w->cast.count);
  bool outside = false;
  for (int k = 0; k < 3; k++) outside = outside || now.lo[k] < w->views.lo[k] || now.hi[k] > w->views.hi[k];
  if (!outside) return;
  hb_views *v = &w->views;
  for (int k = 0; k < 3; k++) {
    v->lo[k] = fmin(v->lo[k], now.lo[k]);
    v->hi[k] = fmax(v->hi[k], now.hi[k]);
  }
  v->along_range[0] = fmin(v->along_range[0], now.along_range[0]);
  v->along_range[1] = fmax(v->along_range[1], now.along_range[1]);
  v->across_range[0] = fmin(v->across_range[0], now.across_range[0]);
  v->across_range[1] = fmax(v->across_range[1], now.across_range[1]);
  frame_views(w);
}

/* Asks the terminal for its size and makes room for a picture of it. */
static hb_status fit_terminal(cli_watch *w, hb_error *err) {
  struct winsize size = {0};
  int rows = 24, columns = 80;
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_row > 0 && size.ws_col > 0) {
    rows = size.ws_row;
    columns = size.ws_col;
  }
  rows = rows < 8 ? 8 : rows > 300 ? 300 : rows;
  columns = columns < 24 ? 24 : columns > 600 ? 600 : columns;
  if (rows == w->rows && columns == w->columns) return HB_OK;
  size_t room = (size_t)(rows + 4) * (size_t)(columns + 4) * CLI_DOTS_CELL;
  char *text = hb_realloc(w->text, room, 1);
  if (!text) return hb_fail_memory(err, "live view");
  w->text = text;
  w->room = room;
  w->rows = rows;
  w->columns = columns;
  return HB_OK;
}

/* Starts ffplay, which shows raw pictures in a window. */
static hb_status open_window(cli_watch *w, hb_error *err) {
  const char *display = getenv("DISPLAY"), *wayland = getenv("WAYLAND_DISPLAY");
  if (!(display && *display) && !(wayland && *wayland))
    return hb_fail(err, HB_ERR_MISSING,
                   "--watch=window needs a display, and DISPLAY is not set; --watch=terminal "
                   "draws in the terminal");
  hb_status status = hb_image_create(WINDOW_WIDTH, WINDOW_HEIGHT, &w->image, err);
  if (status != HB_OK) return status;
  char size[32];
  snprintf(size, sizeof size, "%dx%d", WINDOW_WIDTH, WINDOW_HEIGHT);
  /* Pictures come when they come: stamped close together and never dropped, each is shown at once. */
  const char *const argv[] = {"ffplay",
                              "-hide_banner",
                              "-loglevel",
                              "error",
                              "-probesize",
                              "32",
                              "-fflags",
                              "nobuffer",
                              "-sync",
                              "video",
                              "-noframedrop",
                              "-autoexit",
                              "-f",
                              "rawvideo",
                              "-video_size",
                              size,
                              "-framerate",
                              "1000",
                              "-pixel_format",
                              "rgb24",
                              "-window_title",
                              "hebra",
                              "-i",
                              "-",
                              NULL};
  return cli_pipe_open(&w->pipe, argv, "ffmpeg", NULL, err);
}

/* Checks the terminal and hides its cursor. */
static hb_status open_terminal(cli_watch *w, hb_error *err) {
  if (isatty(STDOUT_FILENO) != 1)
    return hb_fail(
        err, HB_ERR_MISSING,
        "--watch draws in the terminal, and standard output is not one; --watch=window draws in a window");
  w->dots = cli_dots_of_terminal();
  hb_status status = fit_terminal(w, err);
  if (status == HB_OK && fputs("\033[?25l", stdout) < 0) w->broken = true;
  return status;
}

/* Views of the initial shape; then the place to draw. */
hb_status cli_watch_open(const hb_model *model, const char *mode, double speed, cli_watch **out,
                         hb_error *err) {
  *out = NULL;
  bool window = strcmp(mode, "window") == 0;
  if (!window && strcmp(mode, "terminal") != 0)
    return hb_fail(err, HB_ERR_INPUT, "--watch is terminal or window, found '%s'", mode);
  cli_watch *w = hb_alloc(1, sizeof *w);
  if (!w) return hb_fail_memory(err, "live view");
  *w = (cli_watch){.model = model, .window = window, .speed = speed > 0 ? speed : 0};
  hb_status status = cli_cast_from_model(model, &w->cast, err);
  if (status == HB_OK) {
    hb_views_start(&w->views);
    hb_views_add(&w->views, w->cast.tubes, w->cast.count);
    (void)hb_views_aim(&w->views);
    hb_views_measure(&w->views, w->cast.tubes, w->cast.count);
    frame_views(w);
    status = window ? open_window(w, err) : open_terminal(w, err);
  }
  if (status != HB_OK) {
    hb_free(w->text);
    hb_image_free(&w->image);
    cli_cast_free(&w->cast);
    hb_free(w);
    return status;
  }
  *out = w;
  return HB_OK;
}

/* One panel of the terminal: its place in cells and the picture of its dots. */
typedef struct panel {
  const char *title;
  int columns, rows;
  hb_image image;
} panel;

/* A flat camera over the ranges x, y. */
static void flat_camera(const cli_watch *w, const double right[3], const double up[3], const double x[2],
                        const double y[2], double aspect, hb_camera *camera) {
  const hb_views *v = &w->views;
  double forward[3] = {up[1] * right[2] - up[2] * right[1], up[2] * right[0] - up[0] * right[2],
                       up[0] * right[1] - up[1] * right[0]};
  double width = x[1] - x[0], height = y[1] - y[0], size = 0, cx = 0.5 * (x[0] + x[1]),
         cy = 0.5 * (y[0] + y[1]);
  *camera = (hb_camera){.orthographic = true, .height = 1.05 * fmax(height, width / aspect)};
  double middle[3], a = 0, b = 0;
  for (int k = 0; k < 3; k++) {
    middle[k] = 0.5 * (v->lo[k] + v->hi[k]);
    size = fmax(size, v->hi[k] - v->lo[k]);
    a += middle[k] * right[k];
    b += middle[k] * up[k];
  }
  for (int k = 0; k < 3; k++) {
    camera->target[k] = middle[k] + (cx - a) * right[k] + (cy - b) * up[k];
    camera->eye[k] = camera->target[k] - 2 * size * forward[k];
    camera->up[k] = up[k];
  }
}

/* The camera of panel 0 (in space), 1 (along the rod), 2 (along its axis). */
static void panel_camera(const cli_watch *w, int which, double aspect, hb_camera *camera) {
  const hb_views *v = &w->views;
  const double up[3] = {0, 0, 1}, height[2] = {v->lo[2], v->hi[2]};
  if (which == 0) {
    const double *a = v->along, from[3] = {0.42 * a[0] + 0.9 * a[1], 0.42 * a[1] - 0.9 * a[0], 0.46};
    hb_camera_fit(v->lo, v->hi, from, up, false, aspect, camera);
  } else if (which == 1)
    flat_camera(w, v->along, up, v->along_range, height, aspect, camera);
  else if (v->upright)
    flat_camera(w, v->along, v->across, v->along_range, v->across_range, aspect, camera);
  else
    flat_camera(w, v->across, up, v->across_range, height, aspect, camera);
}

/* Draws the dots of a panel on black; lines of cells are twice as high as wide, dots are about square. */
static hb_status draw_panel(cli_watch *w, int which, panel *p, hb_error *err) {
  const unsigned char black[3] = {0, 0, 0};
  hb_status status = hb_image_create(p->columns * CLI_DOTS_ACROSS, p->rows * CLI_DOTS_DOWN, &p->image, err);
  if (status != HB_OK) return status;
  hb_image_fill(&p->image, black);
  hb_camera camera;
  panel_camera(w, which, (double)p->image.width / p->image.height, &camera);
  return hb_render_view(&p->image, 0, 0, p->image.width, p->image.height, w->cast.tubes, w->cast.count,
                        &camera, NULL, err);
}

/* A title centred between blanks or dashes, `columns` wide. */
static size_t title_text(char *text, const char *title, int columns) {
  int length = (int)strlen(title);
  if (length > columns) length = columns;
  int left = (columns - length) / 2;
  return (size_t)sprintf(text, "%*s%.*s%*s", left, "", length, title, columns - length - left, "");
}

/* The terminal's picture as one text: a headline, the view in space on the left, the others on the right. */
static size_t compose(cli_watch *w, const hb_frame *f, panel p[3]) {
  char *at = w->text, head[160];
  if (w->lines > 0) at += sprintf(at, "\033[%dA", w->lines);
  snprintf(head, sizeof head,
           "t = %.6g of %.6g   kinetic %.3e  bending %.3e  twisting %.3e  length error %.1e", f->time,
           w->model->def->method.duration, f->kinetic, f->bending, f->twisting, f->length_error);
  at += sprintf(at, "\r%.*s\033[K\n", w->columns - 1, head);
  int rows = p[0].rows + TITLE_LINES;
  for (int row = 0; row < rows; row++) {
    if (row == 0)
      at += title_text(at, p[0].title, p[0].columns);
    else
      at += cli_dots_row(w->dots, &p[0].image, row - 1, at);
    at += sprintf(at, " | ");
    int lower = row - p[1].rows - TITLE_LINES;
    const panel *q = lower < 0 ? &p[1] : &p[2];
    int inside = lower < 0 ? row - TITLE_LINES : lower - TITLE_LINES;
    if (inside < 0)
      at += title_text(at, q->title, q->columns);
    else
      at += cli_dots_row(w->dots, &q->image, inside, at);
    at += sprintf(at, "\033[K\n");
  }
  w->lines = rows + 1;
  return (size_t)(at - w->text);
}

/* Draws the three panels and writes them over the last ones. */
static hb_status show_terminal(cli_watch *w, const hb_frame *frame, hb_error *err) {
  int rows = w->rows, columns = w->columns;
  hb_status status = fit_terminal(w, err);
  if (status != HB_OK) return status;
  if (w->lines > 0 &&
      (rows != w->rows || columns != w->columns)) { /* another size: start on a clean screen */
    fputs("\033[2J\033[H", stdout);
    w->lines = 0;
  }
  int height = w->rows - HEAD_LINES - TITLE_LINES, left = (w->columns - 4) * 55 / 100,
      right = w->columns - 4 - left;
  int lower = (height - TITLE_LINES) / 2, upper = height - TITLE_LINES - lower;
  panel p[3] = {{.title = "in space", .columns = left, .rows = height},
                {.title = "along the rod", .columns = right, .rows = upper},
                {.title = "along its axis", .columns = right, .rows = lower}};
  for (int k = 0; k < 3 && status == HB_OK; k++) status = draw_panel(w, k, &p[k], err);
  if (status == HB_OK) {
    size_t length = compose(w, frame, p);
    if (fwrite(w->text, 1, length, stdout) != length || fflush(stdout) != 0) w->broken = true;
  }
  for (int k = 0; k < 3; k++) hb_image_free(&p[k].image);
  return status;
}

/* Draws and feeds the window. */
static hb_status show_window(cli_watch *w, const hb_frame *frame, hb_error *err) {
  hb_status status = hb_render_views(&w->image, w->cast.tubes, w->cast.count, &w->views, frame->time,
                                     w->model->def->title, err);
  if (status != HB_OK) return status;
  return cli_pipe_write(&w->pipe, w->image.rgb, (size_t)w->image.width * (size_t)w->image.height * 3, err);
}

/* Sleeps until the wall clock shows that time. */
static void sleep_until(double time) {
  double left = time - hb_clock_now();
  if (!(left > 0)) return;
  struct timespec pause = {(time_t)left, (long)((left - floor(left)) * 1e9)};
  while (nanosleep(&pause, &pause) != 0 && errno == EINTR) {
  }
}

/* Waits if there is a speed; drops frames that come too fast. */
void cli_watch_show(cli_watch *w, const hb_frame *frame) {
  if (!w || w->broken) return;
  double now = hb_clock_now();
  if (!w->timed) {
    w->started = now;
    w->start_time = frame->time;
    w->shown = now - 1;
    w->timed = true;
  }
  bool last = frame->time >= w->model->def->method.duration;
  if (w->speed > 0) sleep_until(fmin(w->started + (frame->time - w->start_time) / w->speed, now + 60));
  now = hb_clock_now();
  if (now - w->shown < fmax(1 / RATE, 2 * w->cost) && !last) return; /* leaves time for the run */
  w->shown = now;
  cli_cast_show(&w->cast, frame->position, frame->m1);
  follow(w);
  hb_status status = w->window ? show_window(w, frame, NULL) : show_terminal(w, frame, NULL);
  w->cost = hb_clock_now() - now;
  if (status != HB_OK) w->broken = true; /* a run does not end because nobody can watch it */
}

/* Cursor back, window closed. */
void cli_watch_close(cli_watch *w) {
  if (!w) return;
  if (w->window)
    (void)cli_pipe_close(&w->pipe, NULL);
  else {
    fputs("\033[?25h\033[0m", stdout);
    fflush(stdout);
  }
  hb_free(w->text);
  hb_image_free(&w->image);
  cli_cast_free(&w->cast);
  hb_free(w);
}
