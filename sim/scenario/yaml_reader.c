#include "yaml_reader.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../common/rigid_pose.h"
#include "../robot/robot_model.h"

#define FILE_MAX_BYTES 1000000
#define SHOWN_BYTES 60 /* of a value in an error */
#define EXPECTED_BYTES 600

/* ---- errors */

static const char *node_text(const yaml_node_t *node) {
    if (node == NULL || node->type == YAML_NO_NODE) {
        return "";
    }
    return node->type == YAML_SCALAR_NODE ? (const char *)node->data.scalar.value
           : node->type == YAML_SEQUENCE_NODE ? "[...]" : "{...}";
}

void yaml_refuse(yaml_reader_t *self, const yaml_node_t *node, const char *key, const char *expected) {
    if (!self->failed) {
        self->failed = true;
        const size_t line = node != NULL ? node->start_mark.line + 1 : 1;
        (void)snprintf(self->error, self->error_size, "%s:%zu: %s '%.*s': expected %s", self->path, line, key,
                       SHOWN_BYTES, node_text(node), expected);
    }
}

/* Edit distance, for "did you mean". */
static size_t unlikeness(const char *a, const char *b) {
    size_t row[SHOWN_BYTES + 1];
    const size_t columns = strnlen(b, SHOWN_BYTES);
    for (size_t j = 0; j <= columns; j++) {
        row[j] = j;
    }
    for (size_t i = 0; a[i] != '\0'; i++) {
        size_t diagonal = row[0];
        row[0] = i + 1;
        for (size_t j = 1; j <= columns; j++) {
            const size_t above = row[j];
            const size_t changed = diagonal + (a[i] != b[j - 1]);
            const size_t moved = (above < row[j - 1] ? above : row[j - 1]) + 1;
            row[j] = changed < moved ? changed : moved;
            diagonal = above;
        }
    }
    return row[columns];
}

/* ---- documents */

static bool fail_to_open(char error[], size_t error_size, const char *path, const char *why) {
    (void)snprintf(error, error_size, "%s: %s", path, why);
    return false;
}

static bool parse(yaml_reader_t *self, FILE *file) {
    yaml_parser_t parser;
    if (yaml_parser_initialize(&parser) == 0) {
        return fail_to_open(self->error, self->error_size, self->path, "no memory");
    }
    yaml_parser_set_input_file(&parser, file);
    bool good = yaml_parser_load(&parser, &self->document) != 0;
    if (!good) {
        (void)snprintf(self->error, self->error_size, "%s:%zu: not YAML: %s", self->path, parser.problem_mark.line + 1,
                       parser.problem != NULL ? parser.problem : "it cannot be read");
    } else {
        yaml_document_t second;
        const bool more = yaml_parser_load(&parser, &second) == 0 || yaml_document_get_root_node(&second) != NULL;
        yaml_document_delete(&second);
        if (more) {
            yaml_document_delete(&self->document);
            good = fail_to_open(self->error, self->error_size, self->path, "expected one YAML document and no more");
        }
    }
    yaml_parser_delete(&parser);
    return good;
}

bool yaml_reader_open(yaml_reader_t *self, const char *path, char error[], size_t error_size) {
    memset(self, 0, sizeof *self);
    self->path = path;
    self->error = error;
    self->error_size = error_size;
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        return fail_to_open(error, error_size, path, strerror(errno));
    }
    const bool seekable = fseek(file, 0, SEEK_END) == 0;
    const long bytes = seekable ? ftell(file) : -1;
    rewind(file);
    bool good = false;
    if (bytes < 0 || bytes > FILE_MAX_BYTES) {
        (void)fail_to_open(error, error_size, path, "expected a scenario file of at most 1 MB");
    } else if (bytes == 0) {
        (void)fail_to_open(error, error_size, path, "is empty");
    } else {
        good = parse(self, file);
    }
    (void)fclose(file);
    if (good && !yaml_is_mapping(yaml_root(self))) {
        good = fail_to_open(error, error_size, path, "expected a mapping of keys at its top, as name: and arm:");
        yaml_document_delete(&self->document);
    }
    return good;
}

void yaml_reader_close(yaml_reader_t *self) {
    yaml_document_delete(&self->document);
}

yaml_node_t *yaml_root(yaml_reader_t *self) {
    return yaml_document_get_root_node(&self->document);
}

/* ---- structure */

bool yaml_is_sequence(const yaml_node_t *node) {
    return node != NULL && node->type == YAML_SEQUENCE_NODE;
}

bool yaml_is_mapping(const yaml_node_t *node) {
    return node != NULL && node->type == YAML_MAPPING_NODE;
}

bool yaml_entry(yaml_reader_t *self, yaml_node_t *map, size_t i, const char **key, yaml_node_t **key_node,
                yaml_node_t **value) {
    if (!yaml_is_mapping(map) || i >= (size_t)(map->data.mapping.pairs.top - map->data.mapping.pairs.start)) {
        return false;
    }
    const yaml_node_pair_t *pair = &map->data.mapping.pairs.start[i];
    *key_node = yaml_document_get_node(&self->document, pair->key);
    *value = yaml_document_get_node(&self->document, pair->value);
    *key = node_text(*key_node);
    return true;
}

static void refuse_key(yaml_reader_t *self, const yaml_node_t *node, const char *what, const char *const keys[]) {
    const char *nearest = keys[0];
    char expected[EXPECTED_BYTES] = "one of";
    for (size_t i = 0; keys[i] != NULL; i++) {
        const size_t used = strlen(expected);
        (void)snprintf(expected + used, sizeof expected - used, "%s %s", i > 0 ? "," : "", keys[i]);
        nearest = unlikeness(node_text(node), keys[i]) < unlikeness(node_text(node), nearest) ? keys[i] : nearest;
    }
    if (unlikeness(node_text(node), nearest) <= 4) {
        (void)snprintf(expected, sizeof expected, "a key it knows; did you mean %s?", nearest);
    }
    char label[SHOWN_BYTES + 20];
    (void)snprintf(label, sizeof label, "%.*s: unknown key", SHOWN_BYTES, what);
    yaml_refuse(self, node, label, expected);
}

void yaml_check_keys(yaml_reader_t *self, yaml_node_t *map, const char *what, const char *const keys[]) {
    if (map != NULL && !yaml_is_mapping(map)) {
        yaml_refuse(self, map, what, "a mapping of keys");
        return;
    }
    const char *key, *other;
    yaml_node_t *key_node, *value;
    for (size_t i = 0; yaml_entry(self, map, i, &key, &key_node, &value); i++) {
        bool known = false;
        for (size_t k = 0; keys[k] != NULL && !known; k++) {
            known = strcmp(key, keys[k]) == 0;
        }
        if (!known) {
            refuse_key(self, key_node, what, keys);
        }
        yaml_node_t *other_node, *other_value;
        for (size_t j = 0; j < i && yaml_entry(self, map, j, &other, &other_node, &other_value); j++) {
            if (strcmp(key, other) == 0) {
                yaml_refuse(self, key_node, what, "each key once");
            }
        }
    }
}

yaml_node_t *yaml_find(yaml_reader_t *self, yaml_node_t *map, const char *key) {
    const char *name;
    yaml_node_t *key_node, *value;
    for (size_t i = 0; yaml_entry(self, map, i, &name, &key_node, &value); i++) {
        if (strcmp(name, key) == 0) {
            return value;
        }
    }
    return NULL;
}

yaml_node_t *yaml_need(yaml_reader_t *self, yaml_node_t *map, const char *what, const char *key) {
    yaml_node_t *value = yaml_find(self, map, key);
    if (value == NULL) {
        char expected[EXPECTED_BYTES];
        (void)snprintf(expected, sizeof expected, "a key %s in it", key);
        yaml_refuse(self, map, what, expected);
    }
    return value;
}

size_t yaml_length(const yaml_node_t *sequence) {
    return yaml_is_sequence(sequence)
               ? (size_t)(sequence->data.sequence.items.top - sequence->data.sequence.items.start) : 0;
}

yaml_node_t *yaml_item(yaml_reader_t *self, yaml_node_t *sequence, size_t i) {
    return i < yaml_length(sequence) ? yaml_document_get_node(&self->document, sequence->data.sequence.items.start[i])
                                     : NULL;
}

/* ---- values */

const char *yaml_text(yaml_reader_t *self, const yaml_node_t *node, const char *key) {
    if (node == NULL || node->type != YAML_SCALAR_NODE) {
        yaml_refuse(self, node, key, "a plain value");
        return "";
    }
    return node_text(node);
}

double yaml_number(yaml_reader_t *self, const yaml_node_t *node, const char *key, double minimum, double maximum) {
    const char *text = yaml_text(self, node, key);
    char *end = NULL;
    const double value = strtod(text, &end);
    char expected[EXPECTED_BYTES];
    if (end == text || *end != '\0' || !(value >= minimum && value <= maximum)) {
        const char *unit = strrchr(key, '_');
        (void)snprintf(expected, sizeof expected, "a plain number from %g to %g%s%s", minimum, maximum,
                       unit != NULL ? " in " : "", unit != NULL ? unit + 1 : "");
        yaml_refuse(self, node, key, expected);
        return minimum;
    }
    return value;
}

void yaml_get_number(yaml_reader_t *self, yaml_node_t *map, const char *key, double minimum, double maximum,
                     double *value) {
    const yaml_node_t *node = yaml_find(self, map, key);
    if (node != NULL) {
        *value = yaml_number(self, node, key, minimum, maximum);
    }
}

void yaml_get_bool(yaml_reader_t *self, yaml_node_t *map, const char *key, bool *value) {
    static const char *const words[] = {"false", "true", NULL};
    const yaml_node_t *node = yaml_find(self, map, key);
    if (node != NULL) {
        *value = yaml_word(self, node, key, words) == 1;
    }
}

void yaml_get_vector(yaml_reader_t *self, yaml_node_t *map, const char *key, size_t count, double minimum,
                     double maximum, double value[]) {
    yaml_node_t *node = yaml_find(self, map, key);
    if (node == NULL) {
        return;
    }
    if (yaml_length(node) != count) {
        char expected[EXPECTED_BYTES];
        (void)snprintf(expected, sizeof expected, "%zu numbers in brackets", count);
        yaml_refuse(self, node, key, expected);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        value[i] = yaml_number(self, yaml_item(self, node, i), key, minimum, maximum);
    }
}

void yaml_get_text(yaml_reader_t *self, yaml_node_t *map, const char *key, char text[], size_t size) {
    const yaml_node_t *node = yaml_find(self, map, key);
    if (node != NULL && (size_t)snprintf(text, size, "%s", yaml_text(self, node, key)) >= size) {
        char expected[EXPECTED_BYTES];
        (void)snprintf(expected, sizeof expected, "at most %zu characters", size - 1);
        yaml_refuse(self, node, key, expected);
    }
}

int yaml_word(yaml_reader_t *self, const yaml_node_t *node, const char *key, const char *const words[]) {
    const char *text = yaml_text(self, node, key);
    char expected[EXPECTED_BYTES] = "one of";
    for (int i = 0; words[i] != NULL; i++) {
        if (strcmp(text, words[i]) == 0) {
            return i;
        }
        const size_t used = strlen(expected);
        (void)snprintf(expected + used, sizeof expected - used, "%s %s", i > 0 ? "," : "", words[i]);
    }
    yaml_refuse(self, node, key, expected);
    return -1;
}

void yaml_get_rotation(yaml_reader_t *self, yaml_node_t *map, const char *key, double rotation[4]) {
    static const char *const keys[] = {"axis", "angle_deg", NULL};
    static const char *const axes[] = {"x", "y", "z", NULL};
    yaml_node_t *product = yaml_find(self, map, key);
    if (product == NULL) {
        return;
    }
    if (!yaml_is_sequence(product)) {
        yaml_refuse(self, product, key, "a product of rotations as [{axis: x, angle_deg: 180}, ...]");
        return;
    }
    const double identity[4] = {1.0, 0.0, 0.0, 0.0};
    memcpy(rotation, identity, sizeof identity);
    for (size_t i = 0; i < yaml_length(product); i++) {
        yaml_node_t *factor = yaml_item(self, product, i);
        double vector[3] = {0.0, 0.0, 0.0}, turn[4];
        yaml_check_keys(self, factor, key, keys);
        const int axis = yaml_word(self, yaml_need(self, factor, key, "axis"), "axis", axes);
        const double angle_deg =
            yaml_number(self, yaml_need(self, factor, key, "angle_deg"), "angle_deg", -360.0, 360.0);
        vector[axis >= 0 ? axis : 0] = angle_deg * ROBOT_RAD_PER_DEG;
        rotation_from_vector(vector, turn);
        rotation_multiply(rotation, turn, rotation);
    }
    rotation_normalise(rotation);
}

void yaml_copy_name(yaml_reader_t *self, const yaml_node_t *node, const char *text, char name[], size_t size) {
    const size_t length = strspn(text, "abcdefghijklmnopqrstuvwxyz0123456789_");
    if (length == 0 || text[length] != '\0' || length >= size || strchr("0123456789_", text[0]) != NULL) {
        yaml_refuse(self, node, "name", "a short name of lower-case letters, digits and underscores");
        return;
    }
    memcpy(name, text, length + 1);
}
