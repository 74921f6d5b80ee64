/* Writes JSON with its commas, indentation and escapes. Keys and text are UTF-8; invalid bytes become U+FFFD. */
#ifndef COMANIP_SIM_JSON_WRITER_H
#define COMANIP_SIM_JSON_WRITER_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

typedef struct {
    FILE *file;
    int depth;
    bool has_member; /* the open object or list already has a member */
} json_writer_t;

/* Begins an object if bracket is '{', or a list if it is '['. In this and the following functions, key is NULL for an
 * element of a list. */
void json_begin(json_writer_t *self, const char *key, char bracket);
void json_end(json_writer_t *self, char bracket);
void json_text(json_writer_t *self, const char *key, const char *value);
void json_unsigned(json_writer_t *self, const char *key, uint64_t value);
void json_bool(json_writer_t *self, const char *key, bool value);
void json_null(json_writer_t *self, const char *key);

/* Writes null for an infinite value or NaN, which JSON cannot represent. */
void json_number(json_writer_t *self, const char *key, double value);

#endif
