/* Workspace of the rod room. */
#include "rod/rod.h"

#include "base/memory.h"

/* Arrays for the longest rod; those of general rods only if there are any. */
hb_status hb_rod_work_create(const hb_model *model, hb_rod_work *w, hb_error *err) {
  size_t n = 0;
  for (int r = 0; r < model->rod_count; r++)
    if ((size_t)model->rods[r].nv > n) n = (size_t)model->rods[r].nv;
  size_t g = model->any_general ? n : 0, frames = (size_t)model->frame_count;
  struct {
    double **array;
    size_t count;
  } arrays[] = {{&w->tangent, 3 * n},
                {&w->inv_length, n},
                {&w->m1, 3 * n},
                {&w->kb, 3 * g},
                {&w->omega, 4 * g},
                {&w->moment, g},
                {&w->stress, 4 * g},
                {&w->B_now, 3 * g},
                {&w->pull, 4 * g},
                {&w->gradient, g},
                {&w->diagonal, g},
                {&w->bending_diagonal, g},
                {&w->off_diagonal, g},
                {&w->delta, n},
                {&w->pivot, g},
                {&w->corner, g},
                {&w->trial_m1, 3 * g},
                {&w->trial_twist, g},
                {&w->frame_now, 3 * frames},
                {&w->frame_turned, frames}};
  size_t total = 0;
  for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++) total += arrays[k].count;
  w->block = hb_alloc(total, sizeof(double));
  w->held = hb_alloc(n, sizeof *w->held);
  if (!w->block || !w->held) {
    hb_rod_work_free(w);
    return hb_fail_memory(err, "workspace of the rods");
  }
  double *next = w->block;
  for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++) {
    *arrays[k].array = next;
    next += arrays[k].count;
  }
  w->bytes = total * sizeof(double) + n * sizeof *w->held;
  return HB_OK;
}

/* Frees the arrays. */
void hb_rod_work_free(hb_rod_work *w) {
  hb_free(w->block);
  hb_free(w->held);
  w->block = NULL;
  w->held = NULL;
}
