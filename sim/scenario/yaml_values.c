#include "yaml_values.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "../common/rigid_pose.h"
#include "../robot/robot_model.h"
#include "yaml_choice.h"

#define WHOLE_NUMBER_DIGITS 9

/* ---- numbers */

/* Endings of keys and the units that they imply. The first match applies. */
static const struct {
    const char *ending, *unit;
} units[] = {
    {"_per_s", "1/s"},
    {"_Nmspprad", "N m s/rad"},
    {"_Nmprad", "N m/rad"},
    {"_Nspm", "N s/m"},
    {"_Npm", "N/m"},
    {"_Nm", "N m"},
    {"_N", "N"},
    {"_kgpm3", "kg/m^3"},
    {"_kg", "kg"},
    {"_radps2", "rad/s^2"},
    {"_rad", "rad"},
    {"_deg", "degrees"},
    {"_percent", "percent"},
    {"_mm", "mm"},
    {"_m", "m"},
    {"_s", "s"},
};

static const char *unit_of(yaml_reader_t *self, const yaml_node_t *node) {
    char path[YAML_PATH_BYTES];
    yaml_path(self, node, path);
    char *bracket = strrchr(path, '[');
    if (bracket != NULL && path[strlen(path) - 1] == ']') {
        *bracket = '\0';
    }
    const size_t length = strlen(path);
    for (size_t i = 0; i < sizeof units / sizeof units[0]; i++) {
        const size_t ending = strlen(units[i].ending);
        if (length > ending && strcmp(path + length - ending, units[i].ending) == 0) {
            return units[i].unit;
        }
    }
    return "";
}

/* Returns true if the text is a decimal number. strtod() alone would also accept blanks, "inf", "nan" and hexadecimal
 * numbers. */
static bool is_decimal(const char *text) {
    char *end = NULL;
    (void)strtod(text, &end);
    return text[0] != '\0' && strspn(text, "+-.0123456789eE") == strlen(text) && *end == '\0';
}

static bool is_quoted(const yaml_node_t *node) {
    return node->type == YAML_SCALAR_NODE && node->data.scalar.style != YAML_PLAIN_SCALAR_STYLE;
}

static void refuse_number(yaml_reader_t *self, const yaml_node_t *node, const char *unit, double minimum,
                          double maximum) {
    if (self->failed) {
        return;
    }
    const char *text = yaml_scalar(node);
    const char *name = unit != NULL ? unit : unit_of(self, node);
    const bool has_unit = !is_decimal(text) && isdigit((unsigned char)text[strspn(text, "+-.")]) != 0;
    const char *without = is_quoted(node) ? ", without quotes," : has_unit ? ", without a unit," : "";
    yaml_refuse(self, node, "a plain number%s%s%s from %g to %g", name[0] != '\0' ? " in " : "", name, without, minimum,
                maximum);
}

double yaml_number(yaml_reader_t *self, const yaml_node_t *node, const char *unit, double minimum, double maximum) {
    const char *text = yaml_scalar(node);
    const double value = is_decimal(text) && !is_quoted(node) ? strtod(text, NULL) : (double)NAN;
    if (!(value >= minimum && value <= maximum)) { /* this rejects NaN too */
        refuse_number(self, node, unit, minimum, maximum);
        return minimum;
    }
    return value;
}

int yaml_whole_number(yaml_reader_t *self, const yaml_node_t *node, int minimum, int maximum) {
    const char *text = yaml_scalar(node);
    const size_t length = strlen(text);
    const bool is_whole = length > 0 && length <= WHOLE_NUMBER_DIGITS && strspn(text, "0123456789") == length;
    const long value = is_whole ? strtol(text, NULL, 10) : -1;
    if (value < minimum || value > maximum || is_quoted(node)) {
        yaml_refuse(self, node, "a plain whole number from %d to %d", minimum, maximum);
        return minimum;
    }
    return (int)value;
}

void yaml_get_number(yaml_reader_t *self, yaml_node_t *map, const char *key, double minimum, double maximum,
                     double *value) {
    const yaml_node_t *node = yaml_find(self, map, key);
    if (node != NULL) {
        *value = yaml_number(self, node, NULL, minimum, maximum);
    }
}

void yaml_need_number(yaml_reader_t *self, yaml_node_t *map, const char *key, double minimum, double maximum,
                      double *value) {
    (void)yaml_need(self, map, key);
    yaml_get_number(self, map, key, minimum, maximum, value);
}

void yaml_get_vector(yaml_reader_t *self, yaml_node_t *map, const char *key, size_t count, double minimum,
                     double maximum, double value[]) {
    yaml_node_t *node = yaml_find(self, map, key);
    if (node == NULL) {
        return;
    }
    if (yaml_length(node) != count) {
        const char *unit = self->failed ? "" : unit_of(self, node);
        yaml_refuse(self, node, "a list of %zu numbers%s%s", count, unit[0] != '\0' ? " in " : "", unit);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        value[i] = yaml_number(self, yaml_item(self, node, i), NULL, minimum, maximum);
    }
}

void yaml_need_vector(yaml_reader_t *self, yaml_node_t *map, const char *key, size_t count, double minimum,
                      double maximum, double value[]) {
    (void)yaml_need(self, map, key);
    yaml_get_vector(self, map, key, count, minimum, maximum, value);
}

/* ---- words, names, texts */

int yaml_word(yaml_reader_t *self, const yaml_node_t *node, const char *const words[]) {
    const int word = yaml_choice(yaml_scalar(node), words);
    if (word < 0 && !self->failed) {
        yaml_refuse_choice(self, node, "words", words);
    }
    return word;
}

void yaml_get_bool(yaml_reader_t *self, yaml_node_t *map, const char *key, bool *value) {
    static const char *const words[] = {"false", "true", NULL};
    const yaml_node_t *node = yaml_find(self, map, key);
    if (node != NULL) {
        *value = yaml_word(self, node, words) == 1;
    }
}

void yaml_name(yaml_reader_t *self, const yaml_node_t *node, char name[], size_t size) {
    const char *text = yaml_scalar(node);
    const size_t length = strlen(text);
    const bool is_name = text[0] >= 'a' && text[0] <= 'z' &&
                         strspn(text, "abcdefghijklmnopqrstuvwxyz0123456789_") == length && length < size;
    if (is_name) {
        memcpy(name, text, length + 1);
    } else if (!self->failed) {
        yaml_refuse(self, node,
                    "a name: a lower-case letter, then lower-case letters, digits or _; "
                    "at most %zu characters",
                    size - 1);
    }
}

void yaml_get_name(yaml_reader_t *self, yaml_node_t *map, const char *key, char name[], size_t size) {
    const yaml_node_t *node = yaml_find(self, map, key);
    if (node != NULL) {
        yaml_name(self, node, name, size);
    }
}

void yaml_get_text(yaml_reader_t *self, yaml_node_t *map, const char *key, char text[], size_t size) {
    const yaml_node_t *node = yaml_find(self, map, key);
    if (node == NULL) {
        return;
    }
    const size_t length = strlen(yaml_scalar(node));
    if (node->type != YAML_SCALAR_NODE || length >= size) {
        yaml_refuse(self, node, "a text of at most %zu bytes", size - 1);
        return;
    }
    memcpy(text, yaml_scalar(node), length + 1);
}

/* ---- rotations */

void yaml_get_rotation(yaml_reader_t *self, yaml_node_t *map, const char *key, double rotation[4]) {
    static const char *const keys[] = {"axis", "angle_deg", NULL};
    static const char *const axes[] = {"x", "y", "z", NULL};
    yaml_node_t *product = yaml_find(self, map, key);
    if (product == NULL) {
        return;
    }
    if (!yaml_is_list(product)) {
        yaml_refuse(self, product, "a product of rotations, for example [{axis: x, angle_deg: 180}, ...]");
    }
    const double identity[4] = {1.0, 0.0, 0.0, 0.0};
    memcpy(rotation, identity, sizeof identity);
    for (size_t i = 0; i < yaml_length(product) && !self->failed; i++) {
        yaml_node_t *factor = yaml_item(self, product, i);
        double vector_rad[3] = {0.0, 0.0, 0.0}, angle_deg = 0.0, turn[4];
        yaml_check_keys(self, factor, keys);
        const int axis = yaml_word(self, yaml_need(self, factor, "axis"), axes);
        yaml_need_number(self, factor, "angle_deg", -360.0, 360.0, &angle_deg);
        vector_rad[axis >= 0 ? axis : 0] = angle_deg * ROBOT_RAD_PER_DEG;
        rotation_from_vector(vector_rad, turn);
        rotation_multiply(rotation, turn, rotation);
    }
    rotation_normalise(rotation);
}
