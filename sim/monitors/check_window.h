/* The time window in which a scenario's check is measured, rounded to the nearest ticks. Each limit of the window is a
 * time since the start of the run or since the first occurrence of an event. */
#ifndef COMANIP_SIM_CHECK_WINDOW_H
#define COMANIP_SIM_CHECK_WINDOW_H

#include <stdbool.h>
#include <stdint.h>

#include "../../firmware/protocol/can_protocol.h"
#include "../scenario/scenario.h"

#define CHECK_WINDOW_TICK_S 0.001

typedef struct {
    bool has_started;       /* the arm has begun to cooperate */
    bool is_open;           /* the start has been reached */
    bool is_closed;         /* the end has been reached, if the check names one */
    uint64_t ticks;         /* ticks in the window so far */
    double first_s, last_s; /* times of the first and the last of these ticks */
} check_window_t;

/* Returns true if the window contains this tick. Called once per tick, in order. events: as they are at the end of the
 * tick.
 *
 * Without `from`, a window begins with the first tick in cooperation. Without `until`, the window covers only ticks in
 * cooperation or hold, so it ends when the operator stops the arm. If the measure applies to the whole run, a missing
 * `from` stands for the start of the run, and a missing `until` for its end. */
bool check_window_contains(check_window_t *self, const scenario_check_t *check, double t_s, control_mode_t mode,
                           const events_t *events);

/* Returns true if every limit that the check names has been reached. */
bool check_window_is_whole(const check_window_t *self, const scenario_check_t *check);

/* Returns the index of an event that a limit of the window refers to but that has not happened; EVENT_NONE if there is
 * none. */
int check_window_missing_event(const check_window_t *self, const scenario_check_t *check, const events_t *events);

#endif
