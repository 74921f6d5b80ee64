/* What one check has measured so far, and what one more tick of its window adds. Definitions: scenario_monitor.h. */
#ifndef COMANIP_SIM_MEASUREMENT_H
#define COMANIP_SIM_MEASUREMENT_H

#include "../scenario/scenario.h"
#include "check_window.h"
#include "observer.h"
#include "physical_state.h"

typedef struct {
    check_window_t window;
    uint64_t ticks;                        /* of the window, in which there was something to measure */
    rigid_pose_t begin_hand, begin_person; /* robot's and person's */
    int begin_left_cup;
    double begin_turns;
    double value;                   /* so far: the largest, the least, the last, the sum */
    double square;                  /* sum of squares */
    double off_m[3];                /* sum of vectors: MEASURE_AIM */
    double square_orientation_deg2; /* MEASURE_FOLLOWING_RMS: what the arm cannot turn */
} measurement_t;

/* What one tick shows. */
typedef struct {
    const tick_record_t *tick;
    const physical_state_t *state;
    const events_t *events;
    double motion_scale;
    const rigid_pose_t *start; /* ODE's hand at the first tick in cooperation; NULL: not yet */
    int particles;             /* of water */
    int newly_left_cup;
    bool is_moving[SCENARIO_MAX_PEOPLE];
    int lost[SCENARIO_MAX_OBJECTS];    /* so often it slipped out of a hand or gripper in this tick */
    int dropped[SCENARIO_MAX_OBJECTS]; /* and so often it became dropped */
} measurement_sight_t;

/* Call in each tick, in the window or not. */
void measurement_sample(measurement_t *self, const scenario_check_t *check, const measurement_sight_t *sight);

/* The window came, as the check names it, with something to measure in it. */
bool measurement_is_valid(const measurement_t *self, const scenario_check_t *check);

/* Meaningless unless valid. */
double measurement_value(const measurement_t *self, const scenario_check_t *check);

/* RMS of the angle between hand and target, which MEASURE_FOLLOWING_RMS does not judge; NaN of other measures. */
double measurement_orientation_rest_deg(const measurement_t *self, const scenario_check_t *check);

#endif
