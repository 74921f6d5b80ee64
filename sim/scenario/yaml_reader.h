/* Typed access to a YAML document (libyaml). The first error is kept as one line that names file, line, key, value and
 * what was expected; after it every reader gives its default, so that callers need to look once, at the end. */
#ifndef COMANIP_SIM_YAML_READER_H
#define COMANIP_SIM_YAML_READER_H

#include <stdbool.h>
#include <stddef.h>
#include <yaml.h>

#define YAML_MAX_KEYS 64

typedef struct {
    yaml_document_t document;
    const char *path;
    char *error;
    size_t error_size;
    bool failed;
} yaml_reader_t;

/* Opens and parses. On failure false, and one line in `error`. One document, no anchors, no tags, at most 1 MB. */
bool yaml_reader_open(yaml_reader_t *self, const char *path, char error[], size_t error_size);
void yaml_reader_close(yaml_reader_t *self);

yaml_node_t *yaml_root(yaml_reader_t *self);

/* A value that cannot be used: "FILE:LINE: KEY 'VALUE': expected EXPECTED". */
void yaml_refuse(yaml_reader_t *self, const yaml_node_t *node, const char *key, const char *expected);

/* ---- mappings; node may be NULL, which has no keys. A NULL-terminated list of keys: any other is refused, with the known
 * key that is most like it. */
void yaml_check_keys(yaml_reader_t *self, yaml_node_t *map, const char *what, const char *const keys[]);
yaml_node_t *yaml_find(yaml_reader_t *self, yaml_node_t *map, const char *key); /* NULL: not there */
yaml_node_t *yaml_need(yaml_reader_t *self, yaml_node_t *map, const char *what, const char *key);

/* Entry i of a mapping, with the key's text. False: there is none. */
bool yaml_entry(yaml_reader_t *self, yaml_node_t *map, size_t i, const char **key, yaml_node_t **key_node,
                yaml_node_t **value);

/* ---- sequences; NULL has no items. */
size_t yaml_length(const yaml_node_t *sequence);
yaml_node_t *yaml_item(yaml_reader_t *self, yaml_node_t *sequence, size_t i);
bool yaml_is_sequence(const yaml_node_t *node);
bool yaml_is_mapping(const yaml_node_t *node);

/* ---- values */

/* The text of a plain value; "" and an error if it is none. */
const char *yaml_text(yaml_reader_t *self, const yaml_node_t *node, const char *key);
double yaml_number(yaml_reader_t *self, const yaml_node_t *node, const char *key, double minimum, double maximum);

/* The same for a key of a mapping. Not there: value, as it was before. */
void yaml_get_number(yaml_reader_t *self, yaml_node_t *map, const char *key, double minimum, double maximum,
                     double *value);
void yaml_get_bool(yaml_reader_t *self, yaml_node_t *map, const char *key, bool *value);
void yaml_get_vector(yaml_reader_t *self, yaml_node_t *map, const char *key, size_t count, double minimum,
                     double maximum, double value[]);

/* Copies; too long a text is refused. */
void yaml_get_text(yaml_reader_t *self, yaml_node_t *map, const char *key, char text[], size_t size);

/* The number of the word in a NULL-terminated list; -1 and an error if it is none of them. */
int yaml_word(yaml_reader_t *self, const yaml_node_t *node, const char *key, const char *const words[]);

/* A product of rotations as Table I writes it, left to right: [{axis: x, angle_deg: 180}, ...]. */
void yaml_get_rotation(yaml_reader_t *self, yaml_node_t *map, const char *key, double rotation[4]);

/* A name of lower-case letters, digits and underscores, that starts with a letter. */
void yaml_copy_name(yaml_reader_t *self, const yaml_node_t *node, const char *text, char name[], size_t size);

#endif
