/* Looks up words in a list of allowed words, such as keys, kinds or names of objects. The error for an unknown word
 * suggests a similar word from the list. */
#ifndef COMANIP_SIM_YAML_CHOICE_H
#define COMANIP_SIM_YAML_CHOICE_H

#include "yaml_reader.h"

/* Returns the index of the word in the NULL-terminated list, or -1 if it is not in the list. */
int yaml_choice(const char *word, const char *const words[]);

/* Reports "expected one of the WHAT a, b, c; did you mean b?". what: the kind of the words, for example "keys". If
 * there is a similar word, the message states the length of a long list instead of the list itself. */
void yaml_refuse_choice(yaml_reader_t *self, const yaml_node_t *node, const char *what, const char *const words[]);

/* Rejects `map` if it is not a mapping, and any key that is not in the NULL-terminated list. If map is NULL, does
 * nothing. */
void yaml_check_keys(yaml_reader_t *self, yaml_node_t *map, const char *const keys[]);

#endif
