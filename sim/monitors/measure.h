/* Properties of the measures of a scenario's checks. */
#ifndef COMANIP_SIM_MEASURE_H
#define COMANIP_SIM_MEASURE_H

#include <stdbool.h>

#include "../scenario/scenario.h"

/* For example "mm"; "" for a count. */
const char *measure_unit(measure_t measure);

/* True if the measure needs the target, which only TickTrace carries. */
bool measure_needs_target(measure_t measure);

/* True if the measure compares the end effector with its pose at the begin of the window. A clutch in between
 * invalidates it. */
bool measure_compares_with_begin(measure_t measure);

/* True if the measure applies to the built-in motion only, not to a recording. */
bool measure_is_of_built_in_motion(measure_t measure);

/* True for measures of objects and water, which may also fall before the start command or after the stop. Their window
 * is the whole run unless the check names another. */
bool measure_is_of_whole_run(measure_t measure);

#endif
