/* Tubes cut into short pieces in camera space, with everything that shading needs at their ends. */
#ifndef HB_RENDER_STRAND_H
#define HB_RENDER_STRAND_H

#include "render/lens.h"

/* A point of a smoothed centreline. */
typedef struct hb_node {
  hb_v3 p, t; /* place and unit tangent */
  hb_v3 u;    /* unit normal, carried along the tube without twist: angles around the tube count from it */
  hb_v3 m;    /* first director; zero: no stripe here */
  double arc; /* length along the strand */
  int tube, strand;
  bool first, last; /* of its strand; a piece goes from every node but the last to the next one */
} hb_node;

/* How a tube looks. Colours are linear light. */
typedef struct hb_look {
  double radius;
  double base[3], stripe[3];
} hb_look;

typedef struct hb_strands {
  hb_node *node;
  int count;
  hb_look *look;
  double radius; /* the largest */
  bool thicket;  /* tubes so many that they are drawn thinner than a single one would be: no stripes, no halos
                  */
  double size;   /* diagonal of the box around the nodes */
  hb_v3 lo, hi;  /* that box, without the radius */
} hb_strands;

/* A tube's stretch with a place that is not a finite number falls apart into strands. */
hb_status hb_strands_make(const hb_tube *tubes, int count, const hb_lens *lens, hb_strands *out,
                          hb_error *err);
void hb_strands_free(hb_strands *strands);

#endif
