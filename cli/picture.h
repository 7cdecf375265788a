/* What the verbs share that draw pictures: reading their arguments, and a file to draw into. */
#ifndef HB_CLI_PICTURE_H
#define HB_CLI_PICTURE_H

#include "cli/cli.h"

/* Does the name end like this, with something in front? */
bool cli_ends_with(const char *name, const char *end);
/* "WIDTHxHEIGHT" in pixels, at least least[0] x least[1] and at most 8192 x 8192; false leaves *width and
 * *height. */
bool cli_read_size(const char *text, const int least[2], int *width, int *height);
/* The only argument after the options, a trajectory; an exit status, or -1 to go on. For use after getopt. */
int cli_read_trajectory(const cli_verb *verb, int argc, char **argv, const char **path);
/* Makes an empty file, so that a name that cannot be written is told before another program is started.
 * name: as the user gave it; what: "picture" or "film". HB_ERR_IO with the reason. */
hb_status cli_try_file(const char *file, const char *name, const char *what, hb_error *err);

#endif
