/* A YAML file (libyaml) as a tree of mappings and lists. The first error is kept as one line that names file, line,
 * path of keys, value and what was expected; after it every reader gives its default, so that callers need to look
 * once, at the end. Values: yaml_values.h. */
#ifndef COMANIP_SIM_YAML_READER_H
#define COMANIP_SIM_YAML_READER_H

#include <stdbool.h>
#include <stddef.h>
#include <yaml.h>

#define YAML_FILE_MAX_BYTES 1000000
#define YAML_MAX_KEYS 64 /* of one mapping */
#define YAML_PATH_BYTES 256

typedef struct {
    yaml_document_t document;
    const char *path;
    char *error;
    size_t error_size;
    bool failed;
    bool is_loaded;
} yaml_reader_t;

/* path and error must outlive the reader. On failure false, and one line in `error`. One document, each key once, and
 * what yaml_screen.h asks for. Close it in any case. */
bool yaml_reader_open(yaml_reader_t *self, const char *path, char error[], size_t error_size);
void yaml_reader_close(yaml_reader_t *self);

yaml_node_t *yaml_root(yaml_reader_t *self);

/* "FILE:LINE: PATH 'VALUE': expected EXPECTED"; without the value if the node is a mapping or a list. Of a key: the
 * path is its mapping's, the value the key itself. */
__attribute__((format(printf, 3, 4))) void yaml_refuse(yaml_reader_t *self, const yaml_node_t *node,
                                                       const char *expected, ...);

/* The node's path of keys, as "people.person.program[2].to_m", list items from 0; "": the whole document. */
void yaml_path(yaml_reader_t *self, const yaml_node_t *node, char path[YAML_PATH_BYTES]);

/* The text of a scalar; "": the node is none. */
const char *yaml_scalar(const yaml_node_t *node);

/* ---- mappings; NULL has no keys */

yaml_node_t *yaml_find(yaml_reader_t *self, yaml_node_t *map, const char *key); /* NULL: not there */
yaml_node_t *yaml_need(yaml_reader_t *self, yaml_node_t *map, const char *key); /* refuses its absence */

/* Entry i of a mapping whose keys are the file's own. False: there is none. */
bool yaml_entry(yaml_reader_t *self, yaml_node_t *map, size_t i, yaml_node_t **key, yaml_node_t **value);

/* Refuses what is no mapping. NULL is fine. */
void yaml_expect_mapping(yaml_reader_t *self, const yaml_node_t *node);
bool yaml_is_mapping(const yaml_node_t *node);

/* ---- lists; NULL has no items */

/* Refuses what is no list, and a list of more than `max` items. NULL is fine. */
void yaml_expect_list(yaml_reader_t *self, const yaml_node_t *node, size_t max);
bool yaml_is_list(const yaml_node_t *node);
size_t yaml_length(const yaml_node_t *list);
yaml_node_t *yaml_item(yaml_reader_t *self, yaml_node_t *list, size_t i); /* NULL: there is none */

#endif
