/* When a step of a script begins: not before a time, after events and a delay, and with patience for them. */
#ifndef COMANIP_SIM_STEP_WAIT_H
#define COMANIP_SIM_STEP_WAIT_H

#include <stdbool.h>
#include <stddef.h>

#include "scenario.h"

/* ready_s: when the step before it ended. False: an event is still to happen. */
bool step_wait_begin_s(const step_start_t *start, const events_t *events, double ready_s, double *begin_s);

/* True: the patience is over at now_s, and `text` says for how long and for which event it waited in vain. */
bool step_wait_in_vain(const step_start_t *start, const events_t *events, double ready_s, double now_s, char text[],
                       size_t size);

/* The name of the first event that has not happened and that this step waits for; NULL: it waits for none. */
const char *step_wait_missing(const step_start_t *start, const events_t *events);

#endif
