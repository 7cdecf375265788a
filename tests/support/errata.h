/* Rows of docs/theory/errata.md: the figure of the printed form and ours, asserted and printed in the form
 * that tests/check_errata.py reads. */
#ifndef HB_TEST_ERRATA_H
#define HB_TEST_ERRATA_H

#include "support/near.h"
#include "support/scenes.h"

/* The printed form is off by at least `least`, ours by at most `most`. Not-a-number fails. */
static inline void errata_row(const char *name, double printed, double least, double ours, double most) {
  say("%s printed %.3g ours %.3g\n", name, printed, ours);
  if (!(printed >= least))
    fail_msg("%s: the printed form is off by %.3g only, not %.3g", name, printed, least);
  if (!(ours <= most)) fail_msg("%s: ours is off by %.3g, allowed %.3g", name, ours, most);
}

#endif
