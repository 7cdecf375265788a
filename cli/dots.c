/* Pixels to braille. */
#include "cli/dots.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Brightness from which on a pixel counts as a dot. */
#define DOT_FROM 44

/* Does the variable contain the text? */
static bool names(const char *variable, const char *text) {
  const char *value = getenv(variable);
  return value && strstr(value, text);
}

/* The first of the locale's variables that is set decides. */
static bool locale_is_utf8(void) {
  const char *const variables[] = {"LC_ALL", "LC_CTYPE", "LANG"};
  for (int k = 0; k < 3; k++) {
    const char *value = getenv(variables[k]);
    if (value && *value) return strstr(value, "UTF-8") || strstr(value, "utf8") || strstr(value, "utf-8");
  }
  return false;
}

/* What the environment tells. */
cli_dots cli_dots_of_terminal(void) {
  cli_dots dots = {.utf8 = locale_is_utf8(), .colors = 256};
  const char *none = getenv("NO_COLOR");
  if (names("COLORTERM", "truecolor") || names("COLORTERM", "24bit")) dots.colors = 1 << 24;
  if ((none && *none) || names("TERM", "dumb")) dots.colors = 0;
  return dots;
}

/* A cell of the picture: which dots are set, their mean colour, and the share of them. */
typedef struct cell {
  unsigned bits;
  int rgb[3], count;
} cell;

/* Bits of a braille character: its dots are numbered down the left column, down the right one, then the
 * lowest row. */
static cell look(const hb_image *image, int column, int row) {
  static const unsigned char bit[CLI_DOTS_DOWN][CLI_DOTS_ACROSS] = {{0, 3}, {1, 4}, {2, 5}, {6, 7}};
  cell c = {0};
  for (int j = 0; j < CLI_DOTS_DOWN; j++)
    for (int i = 0; i < CLI_DOTS_ACROSS; i++) {
      int x = column * CLI_DOTS_ACROSS + i, y = row * CLI_DOTS_DOWN + j;
      if (x >= image->width || y >= image->height) continue;
      const unsigned char *p = image->rgb + 3 * ((size_t)y * (size_t)image->width + (size_t)x);
      int light = p[0] > p[1] ? p[0] : p[1];
      light = light > p[2] ? light : p[2];
      if (light < DOT_FROM) continue;
      c.bits |= 1u << bit[j][i];
      for (int k = 0; k < 3; k++) c.rgb[k] += p[k];
      c.count++;
    }
  for (int k = 0; k < 3 && c.count; k++) c.rgb[k] /= c.count;
  return c;
}

/* Lifts dark colours, which would not be seen on a black terminal, keeping the hue. */
static void lift(int rgb[3]) {
  int most = rgb[0] > rgb[1] ? rgb[0] : rgb[1];
  most = most > rgb[2] ? most : rgb[2];
  if (most >= 150 || most <= 0) return;
  for (int k = 0; k < 3; k++) rgb[k] = rgb[k] * 150 / most;
}

/* Escape sequence of a colour. */
static int color_text(char *text, int colors, const int rgb[3]) {
  if (colors > 256) return sprintf(text, "\033[38;2;%d;%d;%dm", rgb[0], rgb[1], rgb[2]);
  int index = 16;
  for (int k = 0; k < 3; k++) index += (rgb[k] * 5 + 127) / 255 * (k == 0 ? 36 : k == 1 ? 6 : 1);
  return sprintf(text, "\033[38;5;%dm", index);
}

/* Braille, or a character that is about as dense. */
static int dots_text(char *text, bool utf8, const cell *c) {
  static const char dense[] = ".:-=+*#%@";
  if (!c->bits) return sprintf(text, " ");
  if (!utf8) return sprintf(text, "%c", dense[c->count]);
  unsigned code = 0x2800 + c->bits;
  return sprintf(text, "%c%c%c", (int)(0xe0 | code >> 12), (int)(0x80 | (code >> 6 & 63)),
                 (int)(0x80 | (code & 63)));
}

/* Colours are written where they change. */
size_t cli_dots_row(cli_dots dots, const hb_image *image, int row, char *text) {
  int columns = (image->width + CLI_DOTS_ACROSS - 1) / CLI_DOTS_ACROSS, last[3] = {-1, -1, -1};
  char *at = text;
  for (int column = 0; column < columns; column++) {
    cell c = look(image, column, row);
    lift(c.rgb);
    if (c.bits && dots.colors && memcmp(last, c.rgb, sizeof last) != 0) {
      at += color_text(at, dots.colors, c.rgb);
      memcpy(last, c.rgb, sizeof last);
    }
    at += dots_text(at, dots.utf8, &c);
  }
  if (last[0] >= 0) at += sprintf(at, "\033[0m");
  return (size_t)(at - text);
}
