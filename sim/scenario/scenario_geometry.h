/* What no single key shows: whether the scene can be as the file describes it. */
#ifndef COMANIP_SIM_SCENARIO_GEOMETRY_H
#define COMANIP_SIM_SCENARIO_GEOMETRY_H

#include "scenario.h"

/* The start posture is within the joints' range, nothing stands inside something else, the water fits its cup, what the
 * robot holds is in its gripper, nobody moves faster than a person can. On failure false, and one line in `error`. */
bool scenario_check_geometry(const scenario_t *self, char error[], size_t error_size);

#endif
