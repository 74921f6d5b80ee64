/* The time in which a scenario's check is measured: from one moment until another, to the tick that is nearest to each.
 * Moments are times of the run, or counted from an event's first happening. */
#ifndef COMANIP_SIM_CHECK_WINDOW_H
#define COMANIP_SIM_CHECK_WINDOW_H

#include <stdbool.h>
#include <stdint.h>

#include "../../firmware/protocol/can_protocol.h"
#include "../scenario/scenario.h"

#define CHECK_WINDOW_TICK_S 0.001

typedef struct {
    bool has_started;       /* the arm has cooperated */
    bool is_open;           /* its begin has come */
    bool is_closed;         /* its end, where the check names one, has come */
    uint64_t ticks;         /* in it so far */
    double first_s, last_s; /* of these */
} check_window_t;

/* This tick lies in the window. Call once per tick, in order; events: as they stand at its end.
 *
 * A check that names no begin begins with the first tick in cooperation. One that names no end covers the ticks in
 * cooperation and in hold, which end with the operator's stop. Measures of the whole run begin and end with it. */
bool check_window_contains(check_window_t *self, const scenario_check_t *check, double t_s, control_mode_t mode,
                           const events_t *events);

/* Every moment that the check names has come. */
bool check_window_is_whole(const check_window_t *self, const scenario_check_t *check);

/* The number of an event that the window waited for in vain; EVENT_NONE. */
int check_window_missing_event(const check_window_t *self, const scenario_check_t *check, const events_t *events);

#endif
