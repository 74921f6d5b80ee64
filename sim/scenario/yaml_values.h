/* Values of a YAML file: numbers, vectors, rotations, words, names and texts. What is not expected is refused
 * (yaml_reader.h), with the unit that the key's name ends with. */
#ifndef COMANIP_SIM_YAML_VALUES_H
#define COMANIP_SIM_YAML_VALUES_H

#include "yaml_reader.h"

/* Decimal, without quotes. unit: NULL: as the key says. Gives `minimum` if it was refused. */
double yaml_number(yaml_reader_t *self, const yaml_node_t *node, const char *unit, double minimum, double maximum);
int yaml_whole_number(yaml_reader_t *self, const yaml_node_t *node, int minimum, int maximum);

/* The number of the word in a NULL-terminated list; -1: it was refused. */
int yaml_word(yaml_reader_t *self, const yaml_node_t *node, const char *const words[]);

/* A name: lower-case letters, digits and underscores, a letter first. A refused one leaves `name` as it is. */
void yaml_name(yaml_reader_t *self, const yaml_node_t *node, char name[], size_t size);

/* ---- the value of a mapping's key. Not there: what it was before. */

void yaml_get_number(yaml_reader_t *self, yaml_node_t *map, const char *key, double minimum, double maximum,
                     double *value);
void yaml_get_bool(yaml_reader_t *self, yaml_node_t *map, const char *key, bool *value);
void yaml_get_vector(yaml_reader_t *self, yaml_node_t *map, const char *key, size_t count, double minimum,
                     double maximum, double value[]);
void yaml_get_name(yaml_reader_t *self, yaml_node_t *map, const char *key, char name[], size_t size);
void yaml_get_text(yaml_reader_t *self, yaml_node_t *map, const char *key, char text[], size_t size);

/* A product of rotations as Table I writes it, left to right: [{axis: x, angle_deg: 180}, ...]. */
void yaml_get_rotation(yaml_reader_t *self, yaml_node_t *map, const char *key, double rotation[4]);

/* ---- the same, refused if it is not there */

void yaml_need_number(yaml_reader_t *self, yaml_node_t *map, const char *key, double minimum, double maximum,
                      double *value);
void yaml_need_vector(yaml_reader_t *self, yaml_node_t *map, const char *key, size_t count, double minimum,
                      double maximum, double value[]);

#endif
