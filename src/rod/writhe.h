/* Writhe of a polygon: how far a curve in space winds about itself (docs/theory/references.md: Fuller 1971).
 */
#ifndef HB_ROD_WRITHE_H
#define HB_ROD_WRITHE_H

#include <stdbool.h>

/* Exact writhe of the polygon through nv vertices x (3 per vertex); closed: an edge leads from the last back
 * to the first. Right-handed coils count positive. For a closed polygon the Bishop frame carried once around
 * has turned by 2 pi times this, up to whole turns, and linking number = twist/(2 pi) + writhe. Edges that
 * cut each other make it undefined (the value jumps by 2 there). Time grows with nv^2. */
double hb_rod_writhe(const double *x, int nv, bool closed);

#endif
