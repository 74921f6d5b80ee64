/* Checks whether the arm comes to rest when the person's hand does.
 *
 * A still phase is a period of cooperation in which nothing moves the target: the person's desired hand pose is
 * constant, the hand in ODE stays there (REST_HAND_M, REST_HAND_RAD; tremor is averaged out), no hand or gripper grips
 * or releases an object, and the blend of the last command has ended. In each phase of at least REST_PHASE_S, the
 * monitor finds the largest joint speed commanded on the bus in the last REST_WINDOW_TICKS. The arm therefore has at
 * least 1.5 s to come to rest, and an oscillation of 0.5 Hz or more reaches its full speed within one second. */
#ifndef COMANIP_SIM_REST_MONITOR_H
#define COMANIP_SIM_REST_MONITOR_H

#include <stdbool.h>
#include <stdint.h>

#include "observer.h"
#include "physical_state.h"

#define REST_PHASE_S 2.5
#define REST_WINDOW_TICKS 1000
#define REST_HAND_M 0.002 /* a drift of this size over 2.5 s causes joint speeds of at most about 6 mrad/s */
#define REST_HAND_RAD (0.5 * ROBOT_RAD_PER_DEG)
#define REST_BLOCK_TICKS 100 /* averaging time of the hand, about one period of tremor */
#define REST_UNSTILL_S 1.0   /* a hand that moved in this last part of a commanded rest counts as disturbed */

typedef struct {
    int64_t commanded_ns; /* start of the period in which neither person nor operator commands motion */
    int64_t hand_ns;      /* start of the period in which the hand in ODE is still */
    control_mode_t mode;
    int64_t settled_ns;
    rigid_pose_t aim;
    bool holds[SCENARIO_MAX_PEOPLE + 1][SCENARIO_MAX_OBJECTS];
    rigid_pose_t anchor; /* pose at which the hand became still */
    rigid_pose_t block;  /* sum of block_ticks poses since the start of the block */
    int block_ticks;
    int64_t block_ns;                     /* start of the block */
    float speed_radps[REST_WINDOW_TICKS]; /* ring buffer: highest joint speed in each tick; 0: no command */
    uint64_t ticks;
    double phase_s;         /* duration of the current phase */
    double longest_s;       /* longest phase so far, including the current one */
    bool measured;          /* at least one phase was long enough */
    bool disturbed;         /* a rest of REST_PHASE_S was commanded, but the hand moved until the rest ended */
    double speed_radps_max; /* largest speed of all measured phases */
} rest_monitor_t;

void rest_monitor_init(rest_monitor_t *self);

/* Adds a finished tick and the scene at its start. aim: desired hand pose of the tracked person. settled_ns: as in
 * observer_t. */
void rest_monitor_sample(rest_monitor_t *self, const tick_record_t *tick, const physical_state_t *state,
                         const rigid_pose_t *aim, int64_t settled_ns);

/* Ends the current phase at the end of the run. */
void rest_monitor_end(rest_monitor_t *self, int64_t now_ns);

#endif
