/* Link, twist and writhe of closed rods, and of rods whose end frames are held (docs/theory, 9.6). */
#include "hebra/sim.h"

#include "base/memory.h"
#include "math/rotation.h"
#include "rod/writhe.h"

#include <string.h>

/* How far the closing path goes out, in lengths of the rod: more than the rod can reach. */
#define OUT 4
#define TURN (2 * HB_PI)

/* Windings have a meaning only where the ends are one, or both are held. */
bool hb_link_defined(const hb_model *model, int rod) {
  const hb_rod *r = &model->rods[rod];
  return r->closed ||
         (r->nv >= 3 && model->frame_of[r->first] >= 0 && model->frame_of[r->first + r->nv - 2] >= 0);
}

/* The rod's vertices and the corners of the path from its end back to its beginning: straight on from the
 * last edge, out to the side where the ends point apart, and straight into the first edge. Number of points.
 */
static int close_path(const hb_rod *rod, const double *x, double *points) {
  int nv = rod->nv;
  const double *first = x + 3 * (size_t)rod->first, *last = first + 3 * (size_t)(nv - 1);
  hb_v3 a = hb_v3_load(first), b = hb_v3_load(last);
  hb_v3 t0 = hb_v3_unit(hb_v3_sub(hb_v3_load(first + 3), a));
  hb_v3 t1 = hb_v3_unit(hb_v3_sub(b, hb_v3_load(last - 3)));
  double reach = OUT * rod->length;
  memcpy(points, first, 3 * (size_t)nv * sizeof *points);
  if (rod->closed) return nv - 1;
  hb_v3_store(points + 3 * (size_t)nv++, hb_v3_axpy(b, reach, t1));
  if (hb_v3_dot(t0, t1) >= 0) { /* the way straight back would cross the rod */
    hb_v3 along = hb_v3_add(t0, t1), aside = {0, 0, 0};
    double x2 = along.x * along.x, y2 = along.y * along.y, z2 = along.z * along.z;
    if (x2 <= y2 && x2 <= z2)
      aside = (hb_v3){0, along.z, -along.y};
    else if (y2 <= z2)
      aside = (hb_v3){-along.z, 0, along.x};
    else
      aside = (hb_v3){along.y, -along.x, 0};
    hb_v3 middle = hb_v3_scale(0.5, hb_v3_add(a, b));
    hb_v3_store(points + 3 * (size_t)nv++, hb_v3_axpy(middle, 2 * reach, hb_v3_unit(aside)));
  }
  hb_v3_store(points + 3 * (size_t)nv++, hb_v3_axpy(a, -reach, t0));
  return nv;
}

/* Angle from the last director, carried along the closing path, to the first. */
static double closing_angle(const double *points, int rod_points, int count, const double *last_m1,
                            const double *first_m1) {
  hb_v3 d = hb_v3_load(last_m1), t = {0, 0, 0};
  for (int j = rod_points - 2; j <= count; j++) {
    const double *from = points + 3 * (size_t)(j % count), *to = points + 3 * (size_t)((j + 1) % count);
    hb_v3 next = hb_v3_unit(hb_v3_sub(hb_v3_load(to), hb_v3_load(from)));
    if (j > rod_points - 2) d = hb_carry(d, t, next);
    t = next;
  }
  return hb_angle_about(d, hb_v3_load(first_m1), t);
}

/* The three give a whole number. */
static hb_status complete(hb_link *out) {
  double sum = out->twist + out->writhe + out->closing;
  out->link = nearbyint(sum);
  out->error = fabs(sum - out->link);
  return HB_OK;
}

/* What the twist at the joint of a closed rod leaves of the angle between the directors there. */
static double cut_angle(const hb_rod *rod, const hb_frame *frame) {
  size_t last = 3 * (size_t)(rod->first + rod->nv - 2), first = 3 * (size_t)rod->first;
  hb_v3 before =
      hb_v3_unit(hb_v3_sub(hb_v3_load(frame->position + last + 3), hb_v3_load(frame->position + last)));
  hb_v3 t =
      hb_v3_unit(hb_v3_sub(hb_v3_load(frame->position + first + 3), hb_v3_load(frame->position + first)));
  hb_v3 d = hb_carry(hb_v3_load(frame->m1 + last), before, t);
  double angle = hb_angle_about(d, hb_v3_load(frame->m1 + first), t);
  return remainder(angle - frame->twist[rod->first + rod->nv - 1], TURN);
}

/* Twist from the frame, writhe from the positions, closing angle from the directors: three things that know
 * nothing of each other. */
hb_status hb_frame_link(const hb_model *model, const hb_frame *frame, int rod, hb_link *out, hb_error *err) {
  const hb_rod *r = &model->rods[rod];
  double twist = 0;
  memset(out, 0, sizeof *out);
  if (!hb_link_defined(model, rod)) return HB_OK;
  for (int k = r->first + 1; k <= r->first + r->last_joint; k++) twist += frame->twist[k];
  out->defined = true;
  out->twist = twist / TURN;
  if (r->closed) {
    out->writhe = hb_rod_writhe(frame->position + 3 * (size_t)r->first, r->nv - 1, true);
    out->closing = cut_angle(r, frame) / TURN;
    return complete(out);
  }
  double *points = hb_alloc((size_t)r->nv + 3, 3 * sizeof *points);
  if (!points) return hb_fail_memory(err, "closed path of a rod");
  int count = close_path(r, frame->position, points);
  out->writhe = hb_rod_writhe(points, count, true);
  out->closing = closing_angle(points, r->nv, count, frame->m1 + 3 * (size_t)(r->first + r->nv - 2),
                               frame->m1 + 3 * (size_t)r->first) /
                 TURN;
  hb_free(points);
  return complete(out);
}
