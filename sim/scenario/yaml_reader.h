/* Reads a YAML file with libyaml as a tree of mappings and lists. The first error is kept as one line that names the
 * file, the line, the path of keys, the value and what was expected. After an error every function returns its default,
 * so that callers need to check for errors only once, at the end. yaml_values.h reads the values. */
#ifndef COMANIP_SIM_YAML_READER_H
#define COMANIP_SIM_YAML_READER_H

#include <stdbool.h>
#include <stddef.h>
#include <yaml.h>

#define YAML_FILE_MAX_BYTES 1000000
#define YAML_MAX_KEYS 64 /* in one mapping */
#define YAML_PATH_BYTES 256

typedef struct {
    yaml_document_t document;
    const char *path;
    char *error;
    size_t error_size;
    bool failed;
    bool is_loaded;
} yaml_reader_t;

/* Reads a file, which must hold exactly one document, must not repeat a key and must pass yaml_screen(). path and error
 * must outlive the reader. Returns false on failure, with one line in `error`. The reader must be closed in either
 * case. */
bool yaml_reader_open(yaml_reader_t *self, const char *path, char error[], size_t error_size);
void yaml_reader_close(yaml_reader_t *self);

yaml_node_t *yaml_root(yaml_reader_t *self);

/* Reports "FILE:LINE: PATH 'VALUE': expected EXPECTED", without the value if the node is a mapping or a list. If the
 * node is a key, PATH is the path of its mapping, and VALUE is the key. */
__attribute__((format(printf, 3, 4))) void yaml_refuse(yaml_reader_t *self, const yaml_node_t *node,
                                                       const char *expected, ...);

/* Writes the node's path, for example "people.person.program[2].to_m", in which list items count from 0. The path of
 * the whole document is "". */
void yaml_path(yaml_reader_t *self, const yaml_node_t *node, char path[YAML_PATH_BYTES]);

/* Returns the text of a scalar, "" for any other node. */
const char *yaml_scalar(const yaml_node_t *node);

/* ---- mappings; a NULL mapping has no keys */

yaml_node_t *yaml_find(yaml_reader_t *self, yaml_node_t *map, const char *key); /* NULL if there is no such key */
yaml_node_t *yaml_need(yaml_reader_t *self, yaml_node_t *map, const char *key); /* error if missing */

/* Reads entry i of a mapping with arbitrary keys. Returns false if there is no such entry. */
bool yaml_entry(yaml_reader_t *self, yaml_node_t *map, size_t i, yaml_node_t **key, yaml_node_t **value);

/* Rejects a node that is not a mapping. NULL is accepted. */
void yaml_expect_mapping(yaml_reader_t *self, const yaml_node_t *node);
bool yaml_is_mapping(const yaml_node_t *node);

/* ---- lists; a NULL list has no items */

/* Rejects a node that is not a list, and a list of more than `max` items. NULL is accepted. */
void yaml_expect_list(yaml_reader_t *self, const yaml_node_t *node, size_t max);
bool yaml_is_list(const yaml_node_t *node);
size_t yaml_length(const yaml_node_t *list);
yaml_node_t *yaml_item(yaml_reader_t *self, yaml_node_t *list, size_t i); /* NULL if there is no such item */

#endif
