/* Words of which a file must use one: keys, kinds, names of things. A wrong one is refused with the one that was
 * perhaps meant. */
#ifndef COMANIP_SIM_YAML_CHOICE_H
#define COMANIP_SIM_YAML_CHOICE_H

#include "yaml_reader.h"

/* Its number in the NULL-terminated list; -1: it is none of them. */
int yaml_choice(const char *word, const char *const words[]);

/* "expected one of the WHAT a, b, c; did you mean b?": what the words are, as "keys". A long list is left out if there
 * is one that was perhaps meant. */
void yaml_refuse_choice(yaml_reader_t *self, const yaml_node_t *node, const char *what, const char *const words[]);

/* Refuses what is no mapping, and keys that the NULL-terminated list does not hold. A map of NULL has none. */
void yaml_check_keys(yaml_reader_t *self, yaml_node_t *map, const char *const keys[]);

#endif
