/* Numbers as text with a fixed count of decimals, without the cost of printf: trace.csv has some fifty numbers per
 * tick. */
#ifndef COMANIP_SIM_TEXT_NUMBER_H
#define COMANIP_SIM_TEXT_NUMBER_H

/* Writes value, rounded to `decimals` (0..9) places; no terminator. From 1e9 on, and if it is no number: "nan".
 * Gives the end of the text. */
char *text_number_write(char *out, double value, int decimals);

#endif
