/* Does the arm come to rest when the person's hand does?
 *
 * Still is a phase of the cooperation in which nobody moves the target: the person means to hold the hand where it is,
 * ODE's hand does stay there (REST_HAND_M, REST_HAND_RAD; tremor is averaged out), neither it nor the robot's takes or
 * leaves anything, and what the operator commanded last is wholly in force. Whether the robot then moves is for the
 * commands on the bus to say: of each phase of at least REST_PHASE_S, the largest speed that any joint is commanded in
 * its last REST_WINDOW_TICKS. 1.5 s are left to arrive; a swing of 0.5 Hz or more shows its full speed in one second.
 */
#ifndef COMANIP_SIM_REST_MONITOR_H
#define COMANIP_SIM_REST_MONITOR_H

#include <stdbool.h>
#include <stdint.h>

#include "observer.h"
#include "physical_state.h"

#define REST_PHASE_S 2.5
#define REST_WINDOW_TICKS 1000
#define REST_HAND_M 0.002 /* in 2.5 s: no joint turns faster than some 6 mrad/s by it */
#define REST_HAND_RAD (0.5 * ROBOT_RAD_PER_DEG)
#define REST_BLOCK_TICKS 100 /* over which the hand is averaged: about one period of tremor */
#define REST_UNSTILL_S                                                                                                 \
    1.0 /* a hand that moved so shortly before the phase's end was not left where its person held it */

typedef struct {
    int64_t asked_ns; /* since when the person and the operator have asked for stillness ... */
    int64_t hand_ns;  /* ... and since when ODE's hand has been still */
    control_mode_t mode;
    int64_t settled_ns;
    rigid_pose_t aim;
    bool holds[SCENARIO_MAX_PEOPLE + 1][SCENARIO_MAX_OBJECTS];
    rigid_pose_t anchor; /* where the hand came to be still */
    rigid_pose_t block;  /* sums since the block's begin, of block_ticks poses */
    int block_ticks;
    int64_t block_ns;                     /* its begin */
    float speed_radps[REST_WINDOW_TICKS]; /* ring: the fastest joint of each tick, 0: no command */
    uint64_t ticks;
    double phase_s;         /* how long it has been still by now */
    double longest_s;       /* of the phases so far, the present one included */
    bool measured;          /* a phase was long enough */
    bool disturbed;         /* the person held still for REST_PHASE_S, and the hand moved nevertheless up to the end */
    double speed_radps_max; /* of the phases that were */
} rest_monitor_t;

void rest_monitor_init(rest_monitor_t *self);

/* One finished tick and the scene at its begin. aim: where the tracked person wants the hand; settled_ns: the
 * observer's. */
void rest_monitor_sample(rest_monitor_t *self, const tick_record_t *tick, const physical_state_t *state,
                         const rigid_pose_t *aim, int64_t settled_ns);

/* The run is over, and with it the present phase. */
void rest_monitor_end(rest_monitor_t *self, int64_t now_ns);

#endif
