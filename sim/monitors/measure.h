/* What the measures of a scenario's checks have in common, and what tells them apart. */
#ifndef COMANIP_SIM_MEASURE_H
#define COMANIP_SIM_MEASURE_H

#include <stdbool.h>

#include "../scenario/scenario.h"

/* As "mm"; "" for a count. */
const char *measure_unit(measure_t measure);

/* The target is known from TickTrace alone. */
bool measure_needs_target(measure_t measure);

/* It compares the hand with where it was at the window's begin: a clutch in between makes it meaningless. */
bool measure_compares_with_begin(measure_t measure);

/* It asks for what the built-in motion does, and says nothing of a recorded one. */
bool measure_is_of_built_in_motion(measure_t measure);

/* It is about objects and water, which are there before the start command and after the stop: what falls then, falls.
 * The window is the whole run, unless the check names another. */
bool measure_is_of_whole_run(measure_t measure);

#endif
