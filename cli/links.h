/* Link = twist + writhe, looked at in every frame of a run (output.link). */
#ifndef HB_CLI_LINKS_H
#define HB_CLI_LINKS_H

#include "hebra/sim.h"

typedef struct cli_links {
  const hb_model *model;
  double *before;   /* per rod: twist + writhe in the frame before */
  long frames;      /* looked at, of rods that have a link: 0 where there are none */
  double error;     /* largest so far */
  long jumps;       /* times that twist + writhe changed by more than a half between frames */
  hb_status status; /* of the first look that failed */
  hb_error err;
} cli_links;

hb_status cli_links_begin(cli_links *links, const hb_model *model, hb_error *err);
void cli_links_look(cli_links *links, const hb_frame *frame);
void cli_links_free(cli_links *links);

#endif
