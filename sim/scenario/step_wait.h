/* Determines when a step of a script begins. A step begins no earlier than a given time, and no earlier than a given
 * delay after certain events. A timeout limits the wait for the events. */
#ifndef COMANIP_SIM_STEP_WAIT_H
#define COMANIP_SIM_STEP_WAIT_H

#include <stdbool.h>
#include <stddef.h>

#include "scenario.h"

/* Computes when the step begins. ready_s: end of the previous step. Returns false as long as an awaited event has not
 * happened. */
bool step_wait_begin_s(const step_start_t *start, const events_t *events, double ready_s, double *begin_s);

/* Returns true if the step has timed out at now_s; `text` then names the timeout and an event that has not happened. */
bool step_wait_timed_out(const step_start_t *start, const events_t *events, double ready_s, double now_s, char text[],
                         size_t size);

/* Returns the name of the first awaited event that has not happened, or NULL if all awaited events have happened. */
const char *step_wait_missing(const step_start_t *start, const events_t *events);

#endif
