/* Reads scenario files (YAML, docs/scenario-files.md). Unknown keys, words and references, missing values and numbers
 * out of range each give one line that names file, line, key, value and what was expected. Whether the scene is
 * physically possible is checked in sim/feasibility. */
#ifndef COMANIP_SIM_SCENARIO_FILE_H
#define COMANIP_SIM_SCENARIO_FILE_H

#include "scenario.h"

/* name_or_path: "pour" is FOLDER/pour.yaml; with a slash or ".yaml" it is a path. Returns false on failure, with one
 * line in `error`. */
bool scenario_load(scenario_t *self, const char *name_or_path, const char *folder, char error[], size_t error_size);

typedef void scenario_visitor_t(void *context, const char *name, const char *summary);

/* Visits all scenarios of the folder by the name that scenario_load() takes. Returns false on failure, with one line in
 * `error`. */
bool scenario_list(const char *folder, scenario_visitor_t *visit, void *context, char error[], size_t error_size);

#endif
