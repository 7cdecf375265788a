/* Another program fed through a pipe: ffmpeg for films, ffplay for a window, gnuplot for plots. No shell in
 * between. */
#ifndef HB_CLI_PIPE_H
#define HB_CLI_PIPE_H

#include "hebra/base.h"

#include <signal.h>
#include <stdio.h>
#include <sys/types.h>

typedef struct cli_pipe {
  pid_t pid;
  int to;           /* its standard input; -1: closed */
  FILE *complaints; /* its standard error */
  const char *program;
  struct sigaction old_broken; /* what happened on a broken pipe before */
} cli_pipe;

/* Starts argv[0], found in PATH. answer: file that takes its standard output, NULL: dropped. HB_ERR_MISSING
 * names the package if the program is not there. */
hb_status cli_pipe_open(cli_pipe *pipe, const char *const *argv, const char *package, const char *answer,
                        hb_error *err);
/* Feeds bytes; HB_ERR_IO with the program's own words if it does not take them. The pipe is still to be
 * closed. */
hb_status cli_pipe_write(cli_pipe *pipe, const void *bytes, size_t count, hb_error *err);
/* Ends the input and waits for the program; HB_ERR_IO with its own words if it failed. */
hb_status cli_pipe_close(cli_pipe *pipe, hb_error *err);

#endif
