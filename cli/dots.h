/* A picture as characters for a terminal. */
#ifndef HB_CLI_DOTS_H
#define HB_CLI_DOTS_H

#include "hebra/hebra.h"

/* What a terminal can show. */
typedef struct cli_dots {
  bool utf8;  /* braille characters of 2 x 4 dots, else one of a few ASCII characters per cell */
  int colors; /* 0, 256, or 1 << 24 */
} cli_dots;

/* From LC_ALL, LC_CTYPE, LANG, COLORTERM, TERM, NO_COLOR of the environment. */
cli_dots cli_dots_of_terminal(void);
/* Pixels that a cell stands for: 2 across, 4 down. */
enum { CLI_DOTS_ACROSS = 2, CLI_DOTS_DOWN = 4 };
/* Longest text of one cell with its colour, and of the end of a row. */
enum { CLI_DOTS_CELL = 24 };
/* Row `row` of cells of an image whose background is black; text holds CLI_DOTS_CELL * (columns + 1) bytes.
 * Colours are reset at the end of the row. Returns the length. */
size_t cli_dots_row(cli_dots dots, const hb_image *image, int row, char *text);

#endif
