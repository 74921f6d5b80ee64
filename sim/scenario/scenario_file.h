/* Reads scenario files (YAML, docs/scenario-files.md). Nothing wrong passes: unknown keys, words and references,
 * missing values, numbers out of range each give one line that names file, line, key, value and what was expected.
 * Whether the scene can be as the file describes it is another question (sim/feasibility). */
#ifndef COMANIP_SIM_SCENARIO_FILE_H
#define COMANIP_SIM_SCENARIO_FILE_H

#include "scenario.h"

/* name_or_path: "pour" is FOLDER/pour.yaml; with a slash or ".yaml" it is a path. On failure false, and `error`. */
bool scenario_load(scenario_t *self, const char *name_or_path, const char *folder, char error[], size_t error_size);

typedef void scenario_visitor_t(void *context, const char *name, const char *summary);

/* All scenarios of the folder, by the name that scenario_load() takes. On failure false, and one line in `error`. */
bool scenario_list(const char *folder, scenario_visitor_t *visit, void *context, char error[], size_t error_size);

#endif
