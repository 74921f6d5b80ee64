/* Reads scenario files (YAML, docs/scenario-files.md). An unknown key, word or reference, a missing value and a number
 * out of range are each reported in one line that names file, line, key, value and what was expected. Whether the scene
 * is physically possible is checked in sim/feasibility. */
#ifndef COMANIP_SIM_SCENARIO_FILE_H
#define COMANIP_SIM_SCENARIO_FILE_H

#include "scenario.h"

/* name_or_path: a name such as "pour", which stands for FOLDER/pour.yaml, or a path, which contains a slash or ends in
 * ".yaml". Returns false on failure, with one line in `error`. */
bool scenario_load(scenario_t *self, const char *name_or_path, const char *folder, char error[], size_t error_size);

typedef void scenario_visitor_t(void *context, const char *name, const char *summary);

/* Calls visit() for each scenario of the folder, with the name that scenario_load() accepts. Returns false on failure,
 * with one line in `error`. */
bool scenario_list(const char *folder, scenario_visitor_t *visit, void *context, char error[], size_t error_size);

#endif
