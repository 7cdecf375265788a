/* Diagrams of branches for `hebra plot`. */
#ifndef HB_CLI_DIAGRAM_H
#define HB_CLI_DIAGRAM_H

#include "cli/cli.h"

/* Do the arguments of `hebra plot` name a table of branches (.csv)? */
bool cli_wants_diagram(int argc, char **argv);
/* Draws it; an exit status. */
int cli_draw_diagram(int argc, char **argv);

#endif
