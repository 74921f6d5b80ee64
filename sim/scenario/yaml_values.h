/* Reads values of a YAML file: numbers, vectors, rotations, words, names and texts. Errors (yaml_reader.h) name the
 * unit that the key's ending implies. */
#ifndef COMANIP_SIM_YAML_VALUES_H
#define COMANIP_SIM_YAML_VALUES_H

#include "yaml_reader.h"

/* Reads a decimal number without quotes. An error message names `unit` or, if `unit` is NULL, the unit that the
 * key's ending implies. Returns `minimum` after an error. */
double yaml_number(yaml_reader_t *self, const yaml_node_t *node, const char *unit, double minimum, double maximum);
int yaml_whole_number(yaml_reader_t *self, const yaml_node_t *node, int minimum, int maximum);

/* Returns the index of the word in a NULL-terminated list, or -1 after an error. */
int yaml_word(yaml_reader_t *self, const yaml_node_t *node, const char *const words[]);

/* Reads a name: lower-case letters, digits and underscores, beginning with a letter. After an error `name` is
 * unchanged. */
void yaml_name(yaml_reader_t *self, const yaml_node_t *node, char name[], size_t size);

/* ---- the value of a key in a mapping; if the key is missing, the destination stays unchanged */

void yaml_get_number(yaml_reader_t *self, yaml_node_t *map, const char *key, double minimum, double maximum,
                     double *value);
void yaml_get_bool(yaml_reader_t *self, yaml_node_t *map, const char *key, bool *value);
void yaml_get_vector(yaml_reader_t *self, yaml_node_t *map, const char *key, size_t count, double minimum,
                     double maximum, double value[]);
void yaml_get_name(yaml_reader_t *self, yaml_node_t *map, const char *key, char name[], size_t size);
void yaml_get_text(yaml_reader_t *self, yaml_node_t *map, const char *key, char text[], size_t size);

/* Reads a product of rotations, from left to right, as in the paper's Table I: [{axis: x, angle_deg: 180}, ...]. */
void yaml_get_rotation(yaml_reader_t *self, yaml_node_t *map, const char *key, double rotation[4]);

/* ---- the same, but a missing key is an error */

void yaml_need_number(yaml_reader_t *self, yaml_node_t *map, const char *key, double minimum, double maximum,
                      double *value);
void yaml_need_vector(yaml_reader_t *self, yaml_node_t *map, const char *key, size_t count, double minimum,
                      double maximum, double value[]);

#endif
