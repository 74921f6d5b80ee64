/* The firmware's controller_step() on CAN FD with drives and a hand that moves once and then rests: over frames,
 * without ODE. */
#ifndef COMANIP_REST_LOOP_H
#define COMANIP_REST_LOOP_H

#include <stdbool.h>

#include "../../firmware/parameters/parameter_set.h"

#define REST_JOINTS 4
#define REST_WINDOWS 2
#define REST_WINDOW_S 2.0
#define REST_CREEP_RADPS 0.02

/* The plant of a drive: its joint's speed follows what was commanded dead_time_s ago with a first-order lag; the
 * encoder counts whole pulses of 1/209 degree, and is read one tick before the firmware has it. */
typedef struct {
    double start_rad[REST_JOINTS];
    double hand_rotation[4]; /* of the hand in the tracker frame before it moves: w x y z, unit */
    double way_m[3];         /* along which it moves, with minimum jerk, */
    double turn_rad[3];      /* and the rotation vector by which it turns meanwhile, in tracker axes */
    double move_s;           /* so long, from 0.1 s after the start on */
    double dead_time_s, lag_s;
    double end_s[REST_WINDOWS]; /* ends of two windows, after the begin of the move; not decreasing */
} rest_case_t;

typedef struct {
    parameter_set_verdict_t verdict; /* of the parameters */
    result_t start;                  /* how the start was answered; if not accepted, nothing that follows is set */
    control_mode_t mode;             /* at the end */
    int interrupted[REST_WINDOWS];   /* ticks of a window that were no cooperation */
    double peak_radps[REST_WINDOWS][REST_JOINTS]; /* largest commanded speed in a window */
    int sign_changes[REST_WINDOWS]
                    [REST_JOINTS]; /* of the commanded velocity where it is above REST_CREEP_RADPS: a pulse of the
                                      encoder times the gain also changes the sign, at rest, for ever */
    double position_rad[REST_WINDOWS][REST_JOINTS];   /* the joints at a window's end, */
    double velocity_radps[REST_WINDOWS][REST_JOINTS]; /* and what was commanded last */
    double target[7];                                 /* at the end: w x y z, x y z */
} rest_outcome_t;

/* Runs `count` cases with the same parameters. */
void rest_run(const parameters_t *parameters, const rest_case_t cases[], int count, rest_outcome_t outcomes[]);

#endif
