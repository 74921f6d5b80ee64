/* Rejects YAML features that a scenario file must not use, before the file is loaded: more than one document, anchors
 * and aliases, tags, lists or mappings as keys, control characters, nesting deeper than 12 levels. */
#ifndef COMANIP_SIM_YAML_SCREEN_H
#define COMANIP_SIM_YAML_SCREEN_H

#include <stdbool.h>
#include <stddef.h>

/* Returns false on failure, with one line in `error`. */
bool yaml_screen(const char *path, const char *text, size_t length, char error[], size_t error_size);

#endif
