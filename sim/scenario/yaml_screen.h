/* What a scenario file must not use of YAML, found before anything of it is taken: more than one document, anchors and
 * aliases, tags, lists or mappings as keys, control characters, deep nesting. */
#ifndef COMANIP_SIM_YAML_SCREEN_H
#define COMANIP_SIM_YAML_SCREEN_H

#include <stdbool.h>
#include <stddef.h>

/* On failure false, and one line in `error`. */
bool yaml_screen(const char *path, const char *text, size_t length, char error[], size_t error_size);

#endif
