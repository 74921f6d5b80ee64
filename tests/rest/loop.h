/* Runs the firmware's controller_step() on CAN FD in a loop with drives and with a hand that moves once and then rests.
 * The controller, the drives and the tracker exchange frames. ODE is not used. */
#ifndef COMANIP_REST_LOOP_H
#define COMANIP_REST_LOOP_H

#include <stdbool.h>

#include "../../firmware/parameters/parameter_set.h"

#define REST_JOINTS 4
#define REST_WINDOWS 2
#define REST_WINDOW_S 2.0
#define REST_CREEP_RADPS 0.02

/* A case. Each drive is modelled as follows: the joint's speed follows the command issued dead_time_s ago with a
 * first-order lag. The encoder counts whole pulses of 1/209 degree, and the firmware receives its reading one tick
 * later. */
typedef struct {
    double start_rad[REST_JOINTS];
    double hand_rotation[4]; /* rotation in the tracker frame before the move: w x y z, unit */
    double way_m[3];         /* displacement of the minimum-jerk move */
    double turn_rad[3];      /* rotation vector of the move, in tracker axes */
    double move_s;           /* duration of the move, which starts 0.1 s after cooperation begins */
    double dead_time_s, lag_s;
    double end_s[REST_WINDOWS]; /* ends of the two windows, from the start of the move; not decreasing */
} rest_case_t;

typedef struct {
    parameter_set_verdict_t verdict; /* verdict on the parameters */
    result_t start;                  /* answer to the start command; if a refusal, the members below stay 0 */
    control_mode_t mode;             /* mode at the end of the run */
    int interrupted[REST_WINDOWS];   /* number of ticks without cooperation in a window */
    double peak_radps[REST_WINDOWS][REST_JOINTS]; /* largest commanded speed in a window */
    int sign_changes[REST_WINDOWS]
                    [REST_JOINTS]; /* sign changes of the commanded velocity above REST_CREEP_RADPS. Slower velocities
                                      are ignored, because single encoder pulses keep changing their sign at rest */
    double position_rad[REST_WINDOWS][REST_JOINTS];   /* joint positions at a window's end */
    double velocity_radps[REST_WINDOWS][REST_JOINTS]; /* last commanded velocity in the window */
    double target[7];                                 /* target at the end: rotation w x y z, translation x y z [m] */
} rest_outcome_t;

/* Runs `count` cases, all with these parameters. */
void rest_run(const parameters_t *parameters, const rest_case_t cases[], int count, rest_outcome_t outcomes[]);

#endif
