/* hebra render: pictures and films of a trajectory. */
#include "cli/cast.h"
#include "cli/picture.h"
#include "cli/pipe.h"

#include "base/memory.h"
#include "render/tripod.h"

#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Seconds that a film lasts if nobody says how fast it goes. */
#define USUAL_LENGTH 10.0
enum { TEXT_ROOM = 4096 };

/* What was asked for. */
typedef struct request {
  const char *path, *out;
  long frame; /* counted from the end if negative */
  bool by_time, camera, perspective, plain, quiet, colored;
  double time, speed, radius, from[3], color[3];
  int width, height, fps;
} request;

/* Everything that drawing needs. */
typedef struct studio {
  request ask;
  hb_reader *reader;
  const hb_trajectory_info *info;
  double *times;
  bool numbered; /* a film goes by the numbers of frames, not by their times */
  cli_cast cast;
  hb_views views;
  hb_image image;
} studio;

/* A finite number that fills the whole text. */
static bool read_number(const char *text, double *out) {
  char *end = NULL;
  *out = strtod(text, &end);
  return end != text && !*end && isfinite(*out);
}

/* x,y,z: finite numbers. */
static bool read_three(const char *text, double out[3]) {
  for (int k = 0; k < 3; k++) {
    char *end = NULL;
    out[k] = strtod(text, &end);
    if (end == text || !isfinite(out[k]) || *end != (k < 2 ? ',' : 0)) return false;
    text = end + 1;
  }
  return true;
}

/* x,y,z, not all zero. */
static bool read_direction(const char *text, double out[3]) {
  return read_three(text, out) && fabs(out[0]) + fabs(out[1]) + fabs(out[2]) > 0;
}

/* Red, green, blue. */
static bool read_color(const char *text, double out[3]) {
  if (!read_three(text, out)) return false;
  for (int k = 0; k < 3; k++)
    if (out[k] < 0 || out[k] > 1) return false;
  return true;
}

/* A whole number of frames. */
static bool read_frame(const char *text, long *out) {
  char *end = NULL;
  errno = 0;
  *out = strtol(text, &end, 10);
  return end != text && !*end && !errno;
}

/* One option; false if its value is not allowed, with the sentence in *what. */
static bool take_option(int c, const char *value, request *r, const char **what) {
  static const int least[2] = {64, 64};
  double number = 0;
  switch (c) {
  case 'o': r->out = value; return true;
  case 'f': *what = "--frame needs a whole number, -1 is the last frame"; return read_frame(value, &r->frame);
  case 't': *what = "--time needs a number"; return r->by_time = read_number(value, &r->time);
  case 'v':
    *what = "--view is three or camera";
    r->camera = strcmp(value, "camera") == 0;
    return r->camera || strcmp(value, "three") == 0;
  case 'd': *what = "--from needs a direction x,y,z"; return r->camera = read_direction(value, r->from);
  case 'c': *what = "--color needs R,G,B, each from 0 to 1"; return r->colored = read_color(value, r->color);
  case 's':
    *what = "--size needs WIDTHxHEIGHT, each side 64 to 8192";
    return cli_read_size(value, least, &r->width, &r->height);
  case 'p':
    *what = "--fps needs a whole number from 1 to 240";
    if (!read_number(value, &number) || number < 1 || number > 240 || number != floor(number)) return false;
    r->fps = (int)number;
    return true;
  case 'x': *what = "--speed needs a number above 0"; return read_number(value, &r->speed) && r->speed > 0;
  case 'r': *what = "--radius needs a number above 0"; return read_number(value, &r->radius) && r->radius > 0;
  case 'P': r->perspective = r->camera = true; return true;
  case 'q': r->quiet = true; return true;
  case 'n': r->plain = r->camera = true; return true;
  default: *what = "unknown option"; return false;
  }
}

/* Is a film asked for? */
static bool is_film(const request *r) {
  return cli_ends_with(r->out, ".mp4") || cli_ends_with(r->out, ".gif") || cli_ends_with(r->out, ".webm");
}

/* Parses argv; an exit status, or -1 to go on. */
static int parse(int argc, char **argv, request *r) {
  static const struct option longs[] = {
      {"output", required_argument, NULL, 'o'}, {"frame", required_argument, NULL, 'f'},
      {"time", required_argument, NULL, 't'},   {"view", required_argument, NULL, 'v'},
      {"from", required_argument, NULL, 'd'},   {"size", required_argument, NULL, 's'},
      {"fps", required_argument, NULL, 'p'},    {"speed", required_argument, NULL, 'x'},
      {"radius", required_argument, NULL, 'r'}, {"color", required_argument, NULL, 'c'},
      {"perspective", no_argument, NULL, 'P'},  {"plain", no_argument, NULL, 'n'},
      {"quiet", no_argument, NULL, 'q'},        {NULL, 0, NULL, 0}};
  *r = (request){
      .out = "picture.png", .frame = -1, .width = 1280, .height = 720, .fps = 30, .from = {0.5, -0.9, 0.5}};
  opterr = 0;
  for (int c; (c = getopt_long(argc, argv, ":o:q", longs, NULL)) != -1;) {
    const char *what = NULL;
    if (c == ':') return cli_usage(&cli_verb_render, "%s needs a value", argv[optind - 1]);
    if (c == '?') return cli_usage(&cli_verb_render, "unknown option %s", argv[optind - 1]);
    if (!take_option(c, optarg, r, &what))
      return cli_usage(&cli_verb_render, "%s, found '%s'", what, optarg ? optarg : "");
  }
  int result = cli_read_trajectory(&cli_verb_render, argc, argv, &r->path);
  if (result >= 0) return result;
  if (!is_film(r) && !cli_ends_with(r->out, ".png"))
    return cli_usage(&cli_verb_render, "-o %s: the name must end in .png, .mp4, .webm or .gif", r->out);
  return -1;
}

/* The frame nearest to a time. */
static long nearest_frame(const studio *s, double time) {
  long best = 0;
  for (long k = 1; k < s->info->frames; k++)
    if (fabs(s->times[k] - time) < fabs(s->times[best] - time)) best = k;
  return best;
}

/* The frame that a picture shows; an error if there is none of that number. */
static hb_status pick_frame(const studio *s, long *out, hb_error *err) {
  const request *r = &s->ask;
  *out = r->by_time ? nearest_frame(s, r->time) : r->frame < 0 ? r->frame + s->info->frames : r->frame;
  if (*out >= 0 && *out < s->info->frames) return HB_OK;
  return hb_fail(err, HB_ERR_INPUT, "%s: there is no frame %ld; the file has frames 0 to %ld", r->path,
                 r->frame, s->info->frames - 1);
}

/* Along a branch of equilibria times are values of a parameter, which may turn back. */
static bool goes_forward(const studio *s) {
  for (long k = 1; k < s->info->frames; k++)
    if (s->times[k] < s->times[k - 1]) return false;
  return true;
}

/* When a film shows a frame: at its time, or where times turn back one after the other, a unit of time apart.
 */
static double moment(const studio *s, long frame) { return s->numbered ? (double)frame : s->times[frame]; }

/* The frame that a film shows at a time: the last one that is not later. from: one that is certainly not too
 * late. */
static long frame_at(const studio *s, double time, long from) {
  long k = from;
  while (k + 1 < s->info->frames && moment(s, k + 1) <= time + 1e-9 * fabs(time)) k++;
  return k;
}

/* Opens the trajectory and what drawing needs. */
static hb_status prepare(studio *s, hb_error *err) {
  hb_status status = hb_reader_open(s->ask.path, &s->reader, err);
  if (status != HB_OK) return status;
  s->info = hb_reader_info(s->reader);
  if (s->info->frames < 1) return hb_fail(err, HB_ERR_INPUT, "%s: the file holds no frame yet", s->ask.path);
  s->times = hb_alloc((size_t)s->info->frames, sizeof *s->times);
  if (!s->times) return hb_fail_memory(err, "times of the frames");
  status = hb_reader_series(s->reader, "time", s->times, err);
  if (status == HB_OK)
    status = cli_cast_from_reader(s->info, s->ask.colored ? s->ask.color : NULL, &s->cast, err);
  for (int i = 0; status == HB_OK && s->ask.radius > 0 && i < s->cast.count; i++)
    s->cast.tubes[i].radius = s->ask.radius;
  if (status == HB_OK) status = hb_image_create(s->ask.width, s->ask.height, &s->image, err);
  return status;
}

/* The space that the frames first..last use, and the direction in which the rods lead at first, or else
 * later. */
static hb_status survey(studio *s, long first, long last, hb_error *err) {
  bool aimed = false;
  hb_views_start(&s->views);
  long count = last - first + 1, stride = count > 2000 ? count / 1000 : 1; /* enough to see where they go */
  for (int pass = 0; pass < 2; pass++) {
    for (long k = first; k <= last; k = k < last && k + stride > last ? last : k + stride) {
      hb_status status = cli_cast_read(&s->cast, s->reader, k, err);
      if (status != HB_OK) return status;
      if (pass == 0)
        hb_views_add(&s->views, s->cast.tubes, s->cast.count);
      else
        hb_views_measure(&s->views, s->cast.tubes, s->cast.count);
      if (pass == 0 && k == first) aimed = hb_views_aim(&s->views);
    }
    if (pass == 0 && !aimed) (void)hb_views_aim(&s->views);
  }
  return HB_OK;
}

/* One view from the direction asked for, with the shadow on a floor below the rods. */
static hb_status draw_camera(studio *s, double time, hb_error *err) {
  const unsigned char page[3] = {247, 246, 243}, ink[3] = {70, 72, 78};
  const double up[3] = {0, 0, 1};
  hb_image_fill(&s->image, page);
  hb_camera camera;
  hb_camera_fit(s->views.lo, s->views.hi, s->ask.from, up, !s->ask.perspective,
                (double)s->ask.width / s->ask.height, &camera);
  double size = 0;
  for (int k = 0; k < 3; k++) size = fmax(size, s->views.hi[k] - s->views.lo[k]);
  double ground = s->views.lo[2] - 0.02 * size;
  hb_status status = hb_render_view(&s->image, 0, 0, s->ask.width, s->ask.height, s->cast.tubes,
                                    s->cast.count, &camera, &ground, err);
  if (status != HB_OK || s->ask.plain) return status;
  char text[64];
  int scale = s->ask.height / 360 > 1 ? s->ask.height / 360 : 1;
  snprintf(text, sizeof text, "t = %#.4g", time);
  hb_image_text(&s->image, 8 * scale, s->ask.height - 16 * scale, scale, ink, text);
  hb_render_tripod(&s->image, &camera, scale, 36 * scale, 54 * scale);
  return HB_OK;
}

/* Reads a frame and draws it. */
static hb_status draw(studio *s, long frame, hb_error *err) {
  hb_status status = cli_cast_read(&s->cast, s->reader, frame, err);
  if (status != HB_OK) return status;
  double time = s->times[frame];
  if (s->ask.camera) return draw_camera(s, time, err);
  return hb_render_views(&s->image, s->cast.tubes, s->cast.count, &s->views, time, s->info->title, err);
}

/* Looks at a later frame in the direction in which a film of the trajectory starts. */
static hb_status aim_at_start(studio *s, long frame, hb_error *err) {
  hb_views views;
  hb_status status = cli_cast_read(&s->cast, s->reader, 0, err);
  if (status != HB_OK) return status;
  hb_views_start(&views);
  hb_views_add(&views, s->cast.tubes, s->cast.count);
  if (!hb_views_aim(&views)) return HB_OK;
  for (int k = 0; k < 3; k++) {
    views.lo[k] = s->views.lo[k];
    views.hi[k] = s->views.hi[k];
  }
  s->views = views;
  status = cli_cast_read(&s->cast, s->reader, frame, err);
  if (status == HB_OK) hb_views_measure(&s->views, s->cast.tubes, s->cast.count);
  return status;
}

/* One picture. */
static hb_status make_picture(studio *s, hb_error *err) {
  long frame = 0;
  hb_status status = pick_frame(s, &frame, err);
  if (status == HB_OK) status = survey(s, frame, frame, err);
  if (status == HB_OK && frame != 0) status = aim_at_start(s, frame, err);
  if (status == HB_OK) status = draw(s, frame, err);
  if (status == HB_OK) status = hb_image_write_png(&s->image, s->ask.out, err);
  if (status == HB_OK) printf("%s: frame %ld, t = %.6g\n", s->ask.out, frame, s->times[frame]);
  return status;
}

/* 1, 2 or 5 times a power of ten, not below the value. */
static double round_up(double value) {
  double step = pow(10, floor(log10(value)));
  return value <= step ? step : value <= 2 * step ? 2 * step : value <= 5 * step ? 5 * step : 10 * step;
}

/* Arguments of ffmpeg: raw frames in, a film at `part` out. */
static void film_arguments(const request *r, const char *part, char room[2][64], const char *argv[40]) {
  int n = 0;
  snprintf(room[0], sizeof room[0], "%dx%d", r->width, r->height);
  snprintf(room[1], sizeof room[1], "%d", r->fps);
  const char *const input[] = {"ffmpeg", "-hide_banner", "-loglevel", "error", "-y",
                               "-f",     "rawvideo",     "-pix_fmt",  "rgb24", "-s",
                               room[0],  "-r",           room[1],     "-i",    "-"};
  const char *const mp4[] = {"-vf",       "pad=ceil(iw/2)*2:ceil(ih/2)*2",
                             "-c:v",      "libx264",
                             "-preset",   "medium",
                             "-crf",      "18",
                             "-pix_fmt",  "yuv420p",
                             "-movflags", "+faststart",
                             NULL};
  const char *const webm[] = {"-c:v", "libvpx-vp9", "-b:v", "0", "-crf", "28", NULL};
  const char *const gif[] = {
      "-vf", "split[a][b];[a]palettegen=max_colors=160[p];[b][p]paletteuse=dither=none", NULL};
  for (size_t k = 0; k < sizeof input / sizeof input[0]; k++) argv[n++] = input[k];
  const char *const *output = cli_ends_with(r->out, ".gif")    ? gif
                              : cli_ends_with(r->out, ".webm") ? webm
                                                               : mp4;
  for (; *output; output++) argv[n++] = *output;
  argv[n++] = part;
  argv[n] = NULL;
}

/* Name beside the film that keeps its ending, with the protocol that ffmpeg would otherwise guess from
 * colons. */
static bool part_name(const char *out, char *text, size_t size) {
  const char *dot = strrchr(out, '.');
  int length = snprintf(text, size, "file:%.*s.part%s", (int)(dot - out), out, dot);
  return length > 0 && (size_t)length < size;
}

/* Says how far a film is: one line that is written over on a terminal, else a line per tenth. */
static void show_progress(const studio *s, long done, long count, long frame) {
  if (s->ask.quiet) return;
  if (isatty(STDERR_FILENO) == 1) {
    fprintf(stderr, "\rframe %ld of %ld  %3ld%%  t = %.6g \033[K", done, count, 100 * done / count,
            s->times[frame]);
    if (done == count) fputs("\r\033[K", stderr);
    fflush(stderr);
  } else if (done == count || 10 * done / count > 10 * (done - 1) / count)
    fprintf(stderr, "frame %ld of %ld  t = %.6g\n", done, count, s->times[frame]);
}

/* Draws and feeds the frames one by one; a frame that is shown again is not drawn again. */
static hb_status feed(studio *s, cli_pipe *pipe, double step, long count, hb_error *err) {
  size_t bytes = (size_t)s->image.width * (size_t)s->image.height * 3;
  long frame = 0, drawn = -1;
  hb_status status = HB_OK;
  for (long k = 0; status == HB_OK && k < count; k++) {
    frame = k == count - 1 ? s->info->frames - 1 : frame_at(s, moment(s, 0) + step * (double)k, frame);
    if (frame != drawn) status = draw(s, frame, err);
    drawn = frame;
    if (status == HB_OK) status = cli_pipe_write(pipe, s->image.rgb, bytes, err);
    if (status == HB_OK) show_progress(s, k + 1, count, frame);
  }
  return status;
}

/* Starts ffmpeg and feeds it. */
static hb_status encode(studio *s, const char *part, double step, long count, hb_error *err) {
  char room[2][64];
  const char *argv[40];
  cli_pipe pipe;
  film_arguments(&s->ask, part, room, argv);
  hb_status status = cli_pipe_open(&pipe, argv, "ffmpeg", NULL, err);
  if (status != HB_OK) return status;
  status = feed(s, &pipe, step, count, err);
  hb_status closing = cli_pipe_close(&pipe, status == HB_OK ? err : NULL);
  return status == HB_OK ? closing : status;
}

/* A film of the whole trajectory. */
static hb_status make_film(studio *s, hb_error *err) {
  char part[TEXT_ROOM];
  request *r = &s->ask;
  s->numbered = !goes_forward(s);
  double duration = moment(s, s->info->frames - 1) - moment(s, 0);
  if (!(r->speed > 0)) r->speed = duration > 0 ? round_up(0.8 * duration / USUAL_LENGTH) : 1;
  double step = r->speed / r->fps, wanted = floor(duration / step + 1e-6) + 1;
  if (wanted > 1e6)
    return hb_fail(err, HB_ERR_INPUT,
                   "the film would have %.3g frames; a larger --speed or a smaller --fps is needed", wanted);
  if (!part_name(r->out, part, sizeof part))
    return hb_fail(err, HB_ERR_INPUT, "-o %s: the name is too long", r->out);
  const char *file = part + strlen("file:");
  hb_status status = cli_try_file(file, r->out, "film", err);
  if (status != HB_OK) return status;
  status = survey(s, 0, s->info->frames - 1, err);
  if (status == HB_OK) status = encode(s, part, step, (long)wanted, err);
  if (status == HB_OK && rename(file, r->out) != 0)
    status = hb_fail(err, HB_ERR_IO, "%s: the film cannot be put in place: %s", r->out, strerror(errno));
  if (status != HB_OK)
    remove(file);
  else
    printf("%s: %ld frames, %.3g s at %d per second, %.6g units of simulated time per second\n", r->out,
           (long)wanted, wanted / r->fps, r->fps, r->speed);
  return status;
}

/* The verb. */
static int render_verb(int argc, char **argv) {
  studio s = {0};
  hb_error err = {HB_OK, ""};
  int result = parse(argc, argv, &s.ask);
  if (result >= 0) return result;
  hb_status status = prepare(&s, &err);
  if (status == HB_OK) status = is_film(&s.ask) ? make_film(&s, &err) : make_picture(&s, &err);
  hb_image_free(&s.image);
  cli_cast_free(&s.cast);
  hb_free(s.times);
  hb_reader_close(s.reader);
  return status == HB_OK ? CLI_DONE : cli_fail("render", &err);
}

const cli_verb cli_verb_render = {
    "render", "draw a picture or a film of a trajectory",
    "usage: hebra render TRAJECTORY [-o NAME] [options]\n\n"
    "Draws the last frame, or a film of all of them. By default three views are drawn, as in a film of the "
    "program\n"
    "that the method comes from: in space, along the rod, and along its axis. The stripe follows the first "
    "material\n"
    "director, so that twist can be seen.\n\n"
    "  -o, --output NAME   picture (.png) or film (.mp4, .webm, .gif; needs ffmpeg); default picture.png\n"
    "  --frame N           picture of frame N, counted from 0; -1 is the last one (default)\n"
    "  --time T            picture of the frame nearest to time T\n"
    "  --view three        three views in one picture (default)\n"
    "  --view camera       one view\n"
    "  --from X,Y,Z        one view, from this direction; the camera moves back until everything is seen\n"
    "  --perspective       one view in perspective, else parallel\n"
    "  --plain             one view without time, axes and scale bar\n"
    "  --size WxH          size in pixels, default 1280x720\n"
    "  --fps N             frames of film per second, default 30\n"
    "  --speed X           simulated time per second of film; default: the film lasts about 10 seconds\n"
    "  --radius R          radius of the rods as drawn; default: that of the scene\n"
    "  --color R,G,B       colour of all rods, each number from 0 to 1; default: one of a palette for each "
    "rod\n"
    "  -q, --quiet         no progress of a film\n\n"
    "Example:\n"
    "  hebra render out/trajectory.h5 -o film.mp4 --speed 0.1\n",
    render_verb};
