/* Cameras. */
#include "render/lens.h"

#include "math/rotation.h"

/* Continued fraction of the tangent: twelve terms are exact to round-off below 1.5. */
double hb_lens_tan(double angle) {
  double tail = 25, square = angle * angle;
  for (int k = 23; k > 0; k -= 2) tail = k - square / tail;
  return angle / tail;
}

/* The vector if it is finite and not zero, else the fallback, as a unit vector. */
static hb_v3 direction_or(hb_v3 v, hb_v3 fallback) {
  double n = hb_v3_norm(v);
  return n > 1e-140 && n < 1e140 ? hb_v3_scale(1 / n, v) : fallback;
}

/* A finite number, else the fallback. */
static double finite_or(double value, double fallback) { return fabs(value) < 1e150 ? value : fallback; }

/* A finite point. */
static hb_v3 point(const double *p) {
  return (hb_v3){finite_or(p[0], 0), finite_or(p[1], 0), finite_or(p[2], 0)};
}

/* Axes, scale, and limits. */
void hb_lens_make(const hb_camera *camera, hb_rect rect, hb_lens *lens) {
  hb_v3 eye = point(camera->eye), target = point(camera->target), way = hb_v3_sub(target, eye);
  lens->rect = rect;
  lens->eye = eye;
  lens->forward = direction_or(way, (hb_v3){0, 1, 0});
  hb_v3 up = direction_or(hb_v3_load(camera->up), (hb_v3){0, 0, 1});
  hb_v3 right = hb_v3_cross(lens->forward, up);
  lens->right = hb_v3_norm(right) > 1e-6 ? hb_v3_unit(right) : hb_any_normal(lens->forward);
  lens->down = hb_v3_cross(lens->forward, lens->right);
  lens->up = (hb_v3){hb_v3_dot(up, lens->right), hb_v3_dot(up, lens->down), hb_v3_dot(up, lens->forward)};
  lens->cx = rect.x + 0.5 * rect.w;
  lens->cy = rect.y + 0.5 * rect.h;
  lens->orthographic = camera->orthographic;
  double distance = hb_v3_norm(way);
  if (!(distance > 1e-140)) distance = 1;
  if (camera->orthographic) {
    double height = camera->height > 1e-140 && camera->height < 1e140 ? camera->height : 1;
    lens->focal = rect.h / height;
    lens->unit = 1 / lens->focal;
    lens->pixel = 1 / lens->focal;
    lens->near = -HUGE_VAL;
    lens->stretch = 1;
    return;
  }
  double angle = camera->height > 1e-6 && camera->height < 2.9 ? camera->height : 0.6;
  double half = hb_lens_tan(0.5 * angle), wide = half * rect.w / rect.h;
  lens->focal = 0.5 * rect.h / half;
  lens->unit = 1 / lens->focal;
  lens->pixel = distance / lens->focal;
  lens->near = 1e-3 * distance;
  lens->stretch = 1 + half * half + wide * wide;
}

/* Along the camera's axes, from the eye. */
hb_v3 hb_lens_look(const hb_lens *lens, hb_v3 p) {
  hb_v3 d = hb_v3_sub(p, lens->eye);
  return (hb_v3){hb_v3_dot(d, lens->right), hb_v3_dot(d, lens->down), hb_v3_dot(d, lens->forward)};
}

/* Points behind the eye of a perspective camera give nonsense: callers clip first. */
void hb_lens_pixel(const hb_lens *lens, hb_v3 p, double out[2]) {
  double scale = lens->orthographic ? lens->focal : lens->focal / p.z;
  out[0] = lens->cx + scale * p.x;
  out[1] = lens->cy + scale * p.y;
}

/* A corner of the box, without infinities. */
static hb_v3 corner(const double lo[3], const double hi[3], int which) {
  return (hb_v3){finite_or(which & 1 ? hi[0] : lo[0], 0), finite_or(which & 2 ? hi[1] : lo[1], 0),
                 finite_or(which & 4 ? hi[2] : lo[2], 0)};
}

/* Limits of the box on the screen of a camera one unit wide: left, right, top, bottom. */
static void screen_box(const hb_camera *camera, const double lo[3], const double hi[3], double out[4]) {
  hb_lens lens;
  hb_lens_make(camera, (hb_rect){0, 0, 1000, 1000}, &lens);
  out[0] = out[2] = HUGE_VAL;
  out[1] = out[3] = -HUGE_VAL;
  for (int k = 0; k < 8; k++) {
    double at[2];
    hb_lens_pixel(&lens, hb_lens_look(&lens, corner(lo, hi, k)), at);
    for (int c = 0; c < 2; c++) {
      out[2 * c] = fmin(out[2 * c], at[c] / 1000 - 0.5);
      out[2 * c + 1] = fmax(out[2 * c + 1], at[c] / 1000 - 0.5);
    }
  }
}

/* Moves target and eye until the box is centred on the screen and fills it up to a margin of a few percent.
 */
static void centre_box(const double lo[3], const double hi[3], hb_v3 back, double aspect, hb_camera *camera) {
  const double margin = 1.06;
  hb_v3 target = hb_v3_load(camera->target);
  double distance = hb_v3_norm(hb_v3_sub(hb_v3_load(camera->eye), target)), box[4], least = 1e-12 * distance;
  for (int round = 0; round < 12; round++) {
    hb_lens lens;
    hb_lens_make(camera, (hb_rect){0, 0, 1000, 1000}, &lens);
    screen_box(camera, lo, hi, box);
    double size = camera->orthographic ? camera->height : 2 * distance * hb_lens_tan(0.5 * camera->height);
    target = hb_v3_axpy(target, 0.5 * (box[0] + box[1]) * size, lens.right);
    target = hb_v3_axpy(target, 0.5 * (box[2] + box[3]) * size, lens.down);
    double fill = margin * fmax((box[1] - box[0]) / aspect, box[3] - box[2]);
    if (camera->orthographic)
      camera->height = fmax(camera->height * fill, least);
    else { /* what is nearer than the target grows faster: not quite all the way at once */
      double front = 0;
      for (int k = 0; k < 8; k++) front = fmax(front, hb_v3_dot(hb_v3_sub(corner(lo, hi, k), target), back));
      distance = fmax(front + (distance - front) * fill, front * 1.05 + least);
    }
    hb_v3_store(camera->target, target);
    hb_v3_store(camera->eye, hb_v3_axpy(target, distance, back));
  }
}

/* Starts far enough away and closes in. */
void hb_camera_fit(const double lo[3], const double hi[3], const double dir[3], const double up[3],
                   bool orthographic, double aspect, hb_camera *camera) {
  hb_v3 a = corner(lo, hi, 0), b = corner(lo, hi, 7), back = direction_or(hb_v3_load(dir), (hb_v3){0, -1, 0});
  double size = hb_v3_norm(hb_v3_sub(a, b));
  bool empty = !(size > 1e-140);
  if (empty) size = 1;
  if (!(aspect > 1e-3 && aspect < 1e3)) aspect = 1;
  *camera = (hb_camera){.orthographic = orthographic, .height = orthographic ? 2 * size : 0.5};
  hb_v3_store(camera->target, hb_v3_scale(0.5, hb_v3_add(a, b)));
  for (int k = 0; k < 3; k++) camera->up[k] = up[k];
  hb_v3_store(camera->eye, hb_v3_axpy(hb_v3_load(camera->target), 5 * size, back));
  if (!empty) centre_box(lo, hi, back, aspect, camera);
}
