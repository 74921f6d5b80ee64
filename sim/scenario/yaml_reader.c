#include "yaml_reader.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "yaml_screen.h"

#define SHOWN_BYTES 60 /* longest part of a value that an error message shows */
#define EXPECTED_BYTES 1400

/* ---- errors */

const char *yaml_scalar(const yaml_node_t *node) {
    return node != NULL && node->type == YAML_SCALAR_NODE ? (const char *)node->data.scalar.value : "";
}

/* Appends the path from `node` to `target`. Each node has exactly one path, because anchors are not allowed. */
static bool find_path(yaml_reader_t *self, const yaml_node_t *node, const yaml_node_t *target,
                      char path[YAML_PATH_BYTES]) {
    if (node == target) {
        return true;
    }
    const size_t length = strlen(path);
    for (size_t i = 0; i < yaml_length(node); i++) {
        const yaml_node_t *item = yaml_document_get_node(&self->document, node->data.sequence.items.start[i]);
        (void)snprintf(path + length, YAML_PATH_BYTES - length, "[%zu]", i);
        if (find_path(self, item, target, path)) {
            return true;
        }
    }
    const yaml_node_pair_t *pair = yaml_is_mapping(node) ? node->data.mapping.pairs.start : NULL;
    for (; pair != NULL && pair < node->data.mapping.pairs.top; pair++) {
        const yaml_node_t *key = yaml_document_get_node(&self->document, pair->key);
        path[length] = '\0';
        if (key == target) {
            return true;
        }
        (void)snprintf(path + length, YAML_PATH_BYTES - length, "%s%s", length > 0 ? "." : "", yaml_scalar(key));
        if (find_path(self, yaml_document_get_node(&self->document, pair->value), target, path)) {
            return true;
        }
    }
    path[length] = '\0';
    return false;
}

void yaml_path(yaml_reader_t *self, const yaml_node_t *node, char path[YAML_PATH_BYTES]) {
    path[0] = '\0';
    (void)find_path(self, yaml_root(self), node, path);
}

/* Returns how many bytes of the text an error message shows: at most SHOWN_BYTES, without splitting a UTF-8
 * character. */
static int shown_bytes(const char *text) {
    size_t bytes = strnlen(text, SHOWN_BYTES);
    while (bytes > 0 && ((unsigned char)text[bytes] & 0xC0) == 0x80) {
        bytes--;
    }
    return (int)bytes;
}

void yaml_refuse(yaml_reader_t *self, const yaml_node_t *node, const char *expected, ...) {
    if (self->failed) {
        return;
    }
    char path[YAML_PATH_BYTES], text[EXPECTED_BYTES], value[SHOWN_BYTES + 16] = "";
    va_list arguments;
    va_start(arguments, expected);
    (void)vsnprintf(text, sizeof text, expected, arguments);
    va_end(arguments);
    yaml_path(self, node, path);
    if (node->type == YAML_SCALAR_NODE) {
        const char *scalar = yaml_scalar(node);
        const int shown = shown_bytes(scalar);
        (void)snprintf(value, sizeof value, "%s'%.*s%s'", path[0] != '\0' ? " " : "", shown, scalar,
                       scalar[shown] != '\0' ? "..." : "");
    } else if (path[0] == '\0') {
        (void)snprintf(value, sizeof value, "the scenario");
    }
    (void)snprintf(self->error, self->error_size, "%s:%zu: %s%s: expected %s", self->path, node->start_mark.line + 1,
                   path, value, text);
    self->failed = true;
}

/* ---- documents */

/* Returns the file's text, or NULL if the file cannot be read or is too large. */
static char *read_file(yaml_reader_t *self, size_t *length) {
    char *text = malloc(YAML_FILE_MAX_BYTES + 1);
    FILE *file = text != NULL ? fopen(self->path, "rb") : NULL;
    bool is_read = false;
    if (file != NULL) {
        *length = fread(text, 1, YAML_FILE_MAX_BYTES + 1, file);
        is_read = ferror(file) == 0;
    }
    if (!is_read) {
        (void)snprintf(self->error, self->error_size, "%s: expected a scenario file: %s", self->path, strerror(errno));
    } else if (*length > YAML_FILE_MAX_BYTES) {
        (void)snprintf(self->error, self->error_size, "%s: expected a scenario file of at most 1 MB", self->path);
        is_read = false;
    }
    if (file != NULL) {
        (void)fclose(file);
    }
    if (!is_read) {
        free(text);
        text = NULL;
    }
    return text;
}

static bool load(yaml_reader_t *self, const char *text, size_t length) {
    yaml_parser_t parser;
    if (yaml_parser_initialize(&parser) != 0) {
        yaml_parser_set_input_string(&parser, (const unsigned char *)text, length);
        self->is_loaded = yaml_parser_load(&parser, &self->document) != 0;
        yaml_parser_delete(&parser);
    }
    if (!self->is_loaded) { /* must be out of memory, because yaml_screen() has found no syntax error */
        (void)snprintf(self->error, self->error_size, "%s: not enough memory to read it", self->path);
    }
    return self->is_loaded;
}

static void check_repetition(yaml_reader_t *self, yaml_node_t *map) {
    yaml_node_t *key, *other, *value;
    for (size_t i = 0; !self->failed && yaml_entry(self, map, i, &key, &value); i++) {
        if (i == YAML_MAX_KEYS) {
            yaml_refuse(self, map, "at most %d keys", YAML_MAX_KEYS);
        }
        for (size_t j = 0; j < i && yaml_entry(self, map, j, &other, &value); j++) {
            if (strcmp(yaml_scalar(key), yaml_scalar(other)) == 0) {
                yaml_refuse(self, key, "each key once; line %zu has it already", other->start_mark.line + 1);
            }
        }
    }
}

static void check_structure(yaml_reader_t *self) {
    if (!yaml_is_mapping(yaml_root(self))) {
        yaml_refuse(self, yaml_root(self), "a mapping of keys at the top level, such as name: and arm:");
    }
    for (yaml_node_t *node = self->document.nodes.start; node < self->document.nodes.top; node++) {
        check_repetition(self, node);
    }
}

bool yaml_reader_open(yaml_reader_t *self, const char *path, char error[], size_t error_size) {
    *self = (yaml_reader_t){.path = path, .error = error, .error_size = error_size};
    size_t length = 0;
    char *text = read_file(self, &length);
    self->failed = text == NULL || !yaml_screen(path, text, length, error, error_size) || !load(self, text, length);
    free(text);
    if (!self->failed) {
        check_structure(self);
    }
    return !self->failed;
}

void yaml_reader_close(yaml_reader_t *self) {
    if (self->is_loaded) {
        yaml_document_delete(&self->document);
        self->is_loaded = false;
    }
}

yaml_node_t *yaml_root(yaml_reader_t *self) {
    return yaml_document_get_root_node(&self->document);
}

/* ---- mappings */

bool yaml_is_mapping(const yaml_node_t *node) {
    return node != NULL && node->type == YAML_MAPPING_NODE;
}

void yaml_expect_mapping(yaml_reader_t *self, const yaml_node_t *node) {
    if (node != NULL && !yaml_is_mapping(node)) {
        yaml_refuse(self, node, "a mapping of keys to values");
    }
}

bool yaml_entry(yaml_reader_t *self, yaml_node_t *map, size_t i, yaml_node_t **key, yaml_node_t **value) {
    if (!yaml_is_mapping(map) || i >= (size_t)(map->data.mapping.pairs.top - map->data.mapping.pairs.start)) {
        return false;
    }
    const yaml_node_pair_t *pair = &map->data.mapping.pairs.start[i];
    *key = yaml_document_get_node(&self->document, pair->key);
    *value = yaml_document_get_node(&self->document, pair->value);
    return true;
}

yaml_node_t *yaml_find(yaml_reader_t *self, yaml_node_t *map, const char *key) {
    yaml_node_t *candidate, *value;
    for (size_t i = 0; yaml_entry(self, map, i, &candidate, &value); i++) {
        if (strcmp(yaml_scalar(candidate), key) == 0) {
            return value;
        }
    }
    return NULL;
}

yaml_node_t *yaml_need(yaml_reader_t *self, yaml_node_t *map, const char *key) {
    yaml_node_t *value = yaml_find(self, map, key);
    if (value == NULL && !self->failed) {
        yaml_refuse(self, map, "a key %s in it", key);
    }
    return value;
}

/* ---- lists */

bool yaml_is_list(const yaml_node_t *node) {
    return node != NULL && node->type == YAML_SEQUENCE_NODE;
}

void yaml_expect_list(yaml_reader_t *self, const yaml_node_t *node, size_t max) {
    if (node != NULL && !yaml_is_list(node)) {
        yaml_refuse(self, node, "a list");
    } else if (yaml_length(node) > max) {
        yaml_refuse(self, node, "at most %zu items; there are %zu", max, yaml_length(node));
    }
}

size_t yaml_length(const yaml_node_t *list) {
    return yaml_is_list(list) ? (size_t)(list->data.sequence.items.top - list->data.sequence.items.start) : 0;
}

yaml_node_t *yaml_item(yaml_reader_t *self, yaml_node_t *list, size_t i) {
    return i < yaml_length(list) ? yaml_document_get_node(&self->document, list->data.sequence.items.start[i]) : NULL;
}
