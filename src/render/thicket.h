/* Light in a thicket: tubes so many and so thin that none of them is seen for itself. Each would hide less
 * than a pixel of the lamp, so the shadow of single tubes says nothing; what counts is how much tube lies on
 * the way. The space is cut into cells along the lamp's direction, each with the area of tube in it, and
 * light that passes through the optical depth tau comes out weaker by exp(-tau) (Lokovic and Veach, Deep
 * Shadow Maps, 2000, on a grid). */
#ifndef HB_RENDER_THICKET_H
#define HB_RENDER_THICKET_H

#include "render/strand.h"

/* Directions in which the depth is known: towards the lamp and away from it, and four across. */
enum { HB_THICKET_WAYS = 6 };

typedef struct hb_thicket {
  hb_v3 axis[3]; /* two across the light, one towards the lamp; camera space */
  double corner[3], cell;
  int n[3];
  float
      *depth; /* optical depth from the middle of a cell, HB_THICKET_WAYS numbers per cell, to the outside */
} hb_thicket;

/* key: unit vector towards the lamp, camera space. */
hb_status hb_thicket_make(const hb_strands *strands, hb_v3 key, hb_thicket *out, hb_error *err);
void hb_thicket_free(hb_thicket *thicket);
/* Share of the lamp, 0..1, that reaches a point. */
double hb_thicket_sun(const hb_thicket *thicket, hb_v3 p);
/* Share of the lamp and of the sky. */
void hb_thicket_light(const hb_thicket *thicket, hb_v3 p, double *sun, double *sky);

#endif
