/* Properties of the measures of a scenario's checks. */
#ifndef COMANIP_SIM_MEASURE_H
#define COMANIP_SIM_MEASURE_H

#include <stdbool.h>

#include "../scenario/scenario.h"

/* Returns the unit, for example "mm"; "" for a count. */
const char *measure_unit(measure_t measure);

/* Returns true if the measure needs the target, which only TickTrace carries. */
bool measure_needs_target(measure_t measure);

/* Returns true if the measure compares the end effector with its pose at the start of the window. A clutch within the
 * window invalidates such a measure. */
bool measure_compares_with_begin(measure_t measure);

/* Returns true if the measure applies only to the built-in motion, not to a recording. */
bool measure_is_of_built_in_motion(measure_t measure);

/* Returns true if the measure's window is the whole run unless the check names another. This applies to measures of
 * objects and water, because objects and water may also fall before the start command or after the stop. */
bool measure_is_of_whole_run(measure_t measure);

#endif
