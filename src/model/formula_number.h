/* Decimal numbers in text, the same in every locale. */
#ifndef HB_MODEL_FORMULA_NUMBER_H
#define HB_MODEL_FORMULA_NUMBER_H

#include <stdbool.h>
#include <stddef.h>

/* Longest number in characters; anything longer counts as no number. */
#define HB_NUMBER_MAX 4096

/* Reads an unsigned decimal number (digits, at most one point, optional exponent) at the start of text,
 * correctly rounded. Returns how many of the length characters belong to it, 0 if there is none. No
 * hexadecimal, no "inf", no "nan"; a number beyond the largest double gives an infinite *value. */
size_t hb_number_scan(const char *text, size_t length, double *value);

/* Reads a whole field with an optional sign. True if all of it is one finite number. */
bool hb_number_field(const char *text, size_t length, double *value);

/* Writes the shortest of 15, 16 or 17 digits that reads back as value, with a decimal point in every locale.
 */
void hb_number_print(double value, char out[40]);

#endif
