/* Runs the firmware's controller_step() on CAN FD in a closed loop with modelled drives, while the person's hand moves
 * once and then rests. The controller, the drives and the tracker exchange frames. There is no physics engine. */
#ifndef COMANIP_REST_LOOP_H
#define COMANIP_REST_LOOP_H

#include <stdbool.h>

#include "../../firmware/parameters/parameter_set.h"

#define REST_JOINTS 4
#define REST_WINDOWS 2
#define REST_WINDOW_S 2.0
#define REST_CREEP_RADPS 0.02

/* A test case: the arm's start posture, the hand's motion, and the dynamics of the drives. A drive's speed follows the
 * command given dead_time_s earlier, with a first-order lag of time constant lag_s. The encoder counts whole pulses of
 * 1/209 degree, and the firmware receives its reading one tick later. */
typedef struct {
    double start_rad[REST_JOINTS];
    double hand_rotation[4]; /* rotation in the tracker frame before the move: unit quaternion, w x y z */
    double way_m[3];         /* displacement of the minimum-jerk move, in tracker axes */
    double turn_rad[3];      /* rotation vector of the move, in tracker axes */
    double move_s;           /* duration of the move, which starts 0.1 s after cooperation begins */
    double dead_time_s, lag_s;
    double end_s[REST_WINDOWS]; /* ends of the two observation windows, from the start of the move; not decreasing */
} rest_case_t;

typedef struct {
    parameter_set_verdict_t verdict; /* verdict on the parameters */
    result_t start;                  /* answer to the start command; if it is refused, all members below stay 0 */
    control_mode_t mode;             /* mode at the end of the run */
    int interrupted[REST_WINDOWS];   /* number of ticks without cooperation in a window */
    double peak_radps[REST_WINDOWS][REST_JOINTS]; /* largest commanded speed in a window */
    int sign_changes[REST_WINDOWS]
                    [REST_JOINTS]; /* sign changes between commanded velocities above REST_CREEP_RADPS. Slower
                                      velocities are ignored: at rest, single encoder pulses keep changing the sign */
    double position_rad[REST_WINDOWS][REST_JOINTS];   /* joint positions at a window's end */
    double velocity_radps[REST_WINDOWS][REST_JOINTS]; /* last commanded velocity in the window */
    double target[7];                                 /* target at the end: rotation w x y z, translation x y z [m] */
} rest_outcome_t;

/* Runs `count` cases, all with these parameters. */
void rest_run(const parameters_t *parameters, const rest_case_t cases[], int count, rest_outcome_t outcomes[]);

#endif
