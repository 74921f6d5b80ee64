/* Formats numbers with a fixed number of decimals. This is faster than printf(), which matters for trace.csv with its
 * about fifty numbers per tick. */
#ifndef COMANIP_SIM_TEXT_NUMBER_H
#define COMANIP_SIM_TEXT_NUMBER_H

/* Writes value, rounded to `decimals` (0..9) places, without a terminating null. Writes "nan" for NaN and for
 * magnitudes of 1e9 or more. Returns the end of the text. */
char *text_number_write(char *out, double value, int decimals);

#endif
