/* Accumulates the measurement of one check over the ticks of its window. scenario_monitor.h describes the measures. */
#ifndef COMANIP_SIM_MEASUREMENT_H
#define COMANIP_SIM_MEASUREMENT_H

#include "../scenario/scenario.h"
#include "check_window.h"
#include "observer.h"
#include "physical_state.h"

typedef struct {
    check_window_t window;
    uint64_t ticks;                        /* ticks of the window that have a measured value */
    rigid_pose_t begin_hand, begin_person; /* end effector and person's hand at the window's start */
    int begin_left_cup;
    double begin_turns;
    double value;                   /* largest, smallest or last value so far, or the sum */
    double square;                  /* sum of squares */
    double off_m[3];                /* MEASURE_AIM: sum of the error vectors */
    double square_orientation_deg2; /* MEASURE_FOLLOWING_RMS: sum of squares of the orientation error */
} measurement_t;

/* Input of one tick. */
typedef struct {
    const tick_record_t *tick;
    const physical_state_t *state;
    const events_t *events;
    double motion_scale;
    const rigid_pose_t *start; /* end effector at the first tick in cooperation; NULL: there was none yet */
    int particles;             /* number of water particles */
    int newly_left_cup;
    bool is_moving[SCENARIO_MAX_PEOPLE];
    int lost[SCENARIO_MAX_OBJECTS];    /* number of times each object slipped out of a hand or gripper in this tick */
    int dropped[SCENARIO_MAX_OBJECTS]; /* number of times each object was dropped in this tick */
} measurement_input_t;

/* Must be called in every tick, inside the window or not. */
void measurement_sample(measurement_t *self, const scenario_check_t *check, const measurement_input_t *input);

/* Returns true if the window was complete and enough of its ticks have a measured value. */
bool measurement_is_valid(const measurement_t *self, const scenario_check_t *check);

/* Returns the measured value. Call it only if measurement_is_valid() returns true. */
double measurement_value(const measurement_t *self, const scenario_check_t *check);

/* Returns the RMS angle between end effector and target for MEASURE_FOLLOWING_RMS; NaN for other measures. This angle
 * is only reported: the check limits the distance alone. */
double measurement_orientation_rest_deg(const measurement_t *self, const scenario_check_t *check);

#endif
