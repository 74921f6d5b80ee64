/* Accumulates the measurement of one check over the ticks of its window. Definitions: scenario_monitor.h. */
#ifndef COMANIP_SIM_MEASUREMENT_H
#define COMANIP_SIM_MEASUREMENT_H

#include "../scenario/scenario.h"
#include "check_window.h"
#include "observer.h"
#include "physical_state.h"

typedef struct {
    check_window_t window;
    uint64_t ticks;                        /* of the window with a measured value */
    rigid_pose_t begin_hand, begin_person; /* end effector and person's hand at the begin */
    int begin_left_cup;
    double begin_turns;
    double value;                   /* largest, smallest or last value, or sum, so far */
    double square;                  /* sum of squares */
    double off_m[3];                /* sum of vectors: MEASURE_AIM */
    double square_orientation_deg2; /* MEASURE_FOLLOWING_RMS: residual orientation error */
} measurement_t;

/* Input of one tick. */
typedef struct {
    const tick_record_t *tick;
    const physical_state_t *state;
    const events_t *events;
    double motion_scale;
    const rigid_pose_t *start; /* end effector at the first tick in cooperation; NULL: not yet */
    int particles;             /* of water */
    int newly_left_cup;
    bool is_moving[SCENARIO_MAX_PEOPLE];
    int lost[SCENARIO_MAX_OBJECTS];    /* how often it slipped out of a hand or gripper in this tick */
    int dropped[SCENARIO_MAX_OBJECTS]; /* how often it was dropped in this tick */
} measurement_input_t;

/* Called in each tick, inside the window or not. */
void measurement_sample(measurement_t *self, const scenario_check_t *check, const measurement_input_t *input);

/* True if the window of the check was complete and had measured values. */
bool measurement_is_valid(const measurement_t *self, const scenario_check_t *check);

/* Only meaningful if measurement_is_valid(). */
double measurement_value(const measurement_t *self, const scenario_check_t *check);

/* RMS angle between end effector and target, which MEASURE_FOLLOWING_RMS does not check; NaN for other measures. */
double measurement_orientation_rest_deg(const measurement_t *self, const scenario_check_t *check);

#endif
