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
    lens->pixel = 1 / lens->focal;
    lens->near = -HUGE_VAL;
    lens->stretch = 1;
    return;
  }
  double angle = camera->height > 1e-6 && camera->height < 2.9 ? camera->height : 0.6;
  double half = hb_lens_tan(0.5 * angle), wide = half * rect.w / rect.h;
  lens->focal = 0.5 * rect.h / half;
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

/* The eye goes back until all eight corners of the box are inside, with a margin of a few percent. */
void hb_camera_fit(const double lo[3], const double hi[3], const double dir[3], const double up[3],
                   bool orthographic, double aspect, hb_camera *camera) {
  double centre[3], size = 0;
  for (int k = 0; k < 3; k++) {
    double a = finite_or(lo[k], 0), b = finite_or(hi[k], 0);
    centre[k] = 0.5 * (a + b);
    size = fmax(size, fabs(b - a));
  }
  if (!(size > 0)) size = 1;
  if (!(aspect > 1e-3 && aspect < 1e3)) aspect = 1;
  hb_v3 back = direction_or(hb_v3_load(dir), (hb_v3){0, -1, 0});
  *camera = (hb_camera){.orthographic = orthographic, .height = orthographic ? size : 0.5};
  for (int k = 0; k < 3; k++) {
    camera->target[k] = centre[k];
    camera->up[k] = up[k];
  }
  hb_v3_store(camera->eye, hb_v3_axpy(hb_v3_load(centre), size, back));
  hb_lens lens;
  hb_lens_make(camera, (hb_rect){0, 0, 100, 100}, &lens);
  double half = hb_lens_tan(0.25), vertical = 0, horizontal = 0, distance = size;
  for (int corner = 0; corner < 8; corner++) {
    hb_v3 p = {corner & 1 ? finite_or(hi[0], 0) : finite_or(lo[0], 0),
               corner & 2 ? finite_or(hi[1], 0) : finite_or(lo[1], 0),
               corner & 4 ? finite_or(hi[2], 0) : finite_or(lo[2], 0)};
    hb_v3 q = hb_lens_look(&lens, p);
    vertical = fmax(vertical, fabs(q.y));
    horizontal = fmax(horizontal, fabs(q.x));
    distance = fmax(distance, fmax(fabs(q.y), fabs(q.x) / aspect) / half * 1.06 + (size - q.z));
  }
  if (orthographic) {
    camera->height = 2.12 * fmax(vertical, horizontal / aspect);
    if (!(camera->height > 0)) camera->height = size;
    distance = 2 * size;
  }
  hb_v3_store(camera->eye, hb_v3_axpy(hb_v3_load(centre), distance, back));
}
