#include "cli/links.h"

#include "base/memory.h"

#include <math.h>

/* Room for what was seen last. */
hb_status cli_links_begin(cli_links *links, const hb_model *model, hb_error *err) {
  *links = (cli_links){.model = model};
  links->before = hb_alloc((size_t)model->rod_count, sizeof *links->before);
  return links->before ? HB_OK : hb_fail_memory(err, "links of the rods");
}

/* All rods that have one. */
void cli_links_look(cli_links *links, const hb_frame *frame) {
  bool any = false;
  for (int r = 0; !links->status && r < links->model->rod_count; r++) {
    hb_link link;
    if (!hb_link_defined(links->model, r)) continue;
    links->status = hb_frame_link(links->model, frame, r, &link, &links->err);
    double now = link.twist + link.writhe;
    links->error = fmax(links->error, link.error);
    links->jumps += links->frames > 0 && fabs(now - links->before[r]) > 0.5;
    links->before[r] = now;
    any = true;
  }
  links->frames += any;
}

/* The array. */
void cli_links_free(cli_links *links) {
  hb_free(links->before);
  links->before = NULL;
}
