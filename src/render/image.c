/* A picture in memory and on disk. */
#include "hebra/render.h"

#include "base/memory.h"

#include <errno.h>
#include <png.h>
#include <setjmp.h>
#include <stdio.h>
#include <string.h>

/* Largest side: keeps every product of sizes inside an int. */
#define MAX_SIDE 16384

/* White picture of the given size; 1..16384 on each side. */
hb_status hb_image_create(int width, int height, hb_image *image, hb_error *err) {
  *image = (hb_image){0};
  if (width < 1 || height < 1 || width > MAX_SIDE || height > MAX_SIDE)
    return hb_fail(err, HB_ERR_INPUT, "the picture's size is %d x %d; each side must be 1 to %d pixels",
                   width, height, MAX_SIDE);
  image->rgb = hb_alloc((size_t)width * (size_t)height, 3);
  if (!image->rgb) return hb_fail_memory(err, "picture");
  image->width = width;
  image->height = height;
  memset(image->rgb, 255, (size_t)width * (size_t)height * 3);
  return HB_OK;
}

/* Frees the pixels; the struct can be used again. */
void hb_image_free(hb_image *image) {
  if (!image) return;
  hb_free(image->rgb);
  *image = (hb_image){0};
}

/* One colour everywhere. */
void hb_image_fill(hb_image *image, const unsigned char rgb[3]) {
  size_t count = (size_t)image->width * (size_t)image->height;
  for (size_t i = 0; i < count; i++) memcpy(image->rgb + 3 * i, rgb, 3);
}

/* What libpng needs to come back to us with its complaint. */
typedef struct png_trouble {
  jmp_buf back;
  char text[160];
} png_trouble;

/* libpng's way of failing: keep the sentence, jump back. */
static void on_png_error(png_structp png, png_const_charp text) {
  png_trouble *trouble = png_get_error_ptr(png);
  snprintf(trouble->text, sizeof trouble->text, "%s", text);
  longjmp(trouble->back, 1);
}

/* Warnings of libpng concern damaged input, which a writer does not have. */
static void on_png_warning(png_structp png, png_const_charp text) {
  (void)png;
  (void)text;
}

/* Encodes into an open file. Returns false with the reason in trouble. */
static bool encode(const hb_image *image, FILE *file, png_trouble *trouble) {
  snprintf(trouble->text, sizeof trouble->text, "out of memory");
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, trouble, on_png_error, on_png_warning);
  if (!png) return false;
  png_infop info = png_create_info_struct(png);
  if (!info || setjmp(trouble->back)) {
    png_destroy_write_struct(&png, &info);
    return false;
  }
  png_init_io(png, file);
  png_set_IHDR(png, info, (png_uint_32)image->width, (png_uint_32)image->height, 8, PNG_COLOR_TYPE_RGB,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  for (int y = 0; y < image->height; y++)
    png_write_row(png, image->rgb + (size_t)y * (size_t)image->width * 3);
  png_write_end(png, NULL);
  png_destroy_write_struct(&png, &info);
  return true;
}

/* Writes beside path and renames, so that a reader never sees half a picture. */
hb_status hb_image_write_png(const hb_image *image, const char *path, hb_error *err) {
  size_t size = strlen(path) + 6;
  char *part = hb_alloc(size, 1);
  if (!part) return hb_fail_memory(err, "name of a picture");
  snprintf(part, size, "%s.part", path);
  FILE *file = fopen(part, "wb");
  if (!file) {
    hb_status status =
        hb_fail(err, HB_ERR_IO, "%s: the picture cannot be written: %s", path, strerror(errno));
    hb_free(part);
    return status;
  }
  png_trouble trouble;
  hb_status status = HB_OK;
  if (!encode(image, file, &trouble))
    status = hb_fail(err, HB_ERR_IO, "%s: the picture cannot be written: %s", path, trouble.text);
  if (fclose(file) != 0 && status == HB_OK)
    status = hb_fail(err, HB_ERR_IO, "%s: the picture cannot be written: %s", path, strerror(errno));
  if (status == HB_OK && rename(part, path) != 0)
    status = hb_fail(err, HB_ERR_IO, "%s: the picture cannot be put in place: %s", path, strerror(errno));
  if (status != HB_OK) remove(part);
  hb_free(part);
  return status;
}
