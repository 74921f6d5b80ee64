/* Runs the firmware in a closed loop without physics, much faster than real time. The loop consists of
 * controller_step() with CAN FD frames, drives that follow their commands with a lag, and encoders. Events within a
 * tick have the same order as in the simulator (sim/world/world.c): a command takes effect in the tick that sends it,
 * and the encoder readings of a tick reach the firmware in the next tick. */
#ifndef COMANIP_KINEMATIC_LOOP_H
#define COMANIP_KINEMATIC_LOOP_H

#include <stddef.h>

#include "../../../firmware/controller.h"

/* ---- the arm: joints that follow their velocity commands with a lag */

typedef struct {
    int joint_count;
    double lag_s; /* time constant of the velocity servo */
    double position_rad[ARM_MAX_JOINTS];
    double velocity_radps[ARM_MAX_JOINTS];
} kinematic_arm_t;

/* start_rad: joint_count values. */
void kinematic_arm_init(kinematic_arm_t *self, int joint_count, double lag_s, const double start_rad[]);

/* Simulates one tick of 1 ms. command_radps and encoder_rad have joint_count values. encoder_rad receives the readings
 * at the beginning of the tick. */
void kinematic_arm_step(kinematic_arm_t *self, const float command_radps[], float encoder_rad[]);

/* ---- the firmware in a loop with the arm */

/* A HandPose frame on the bus. */
typedef struct {
    uint32_t received_us; /* time of reception on the firmware's clock; must not decrease from sample to sample */
    hand_pose_t pose;
} kinematic_sample_t;

typedef struct {
    const arm_ik_t *ik;
    parameters_t parameters;
    double lag_s;                   /* time constant of the drives */
    uint32_t period_us, latency_us; /* as announced in TrackerStatus, 10 times a second */
    uint8_t task;                   /* task_id_t that the operator selects */
    uint32_t start_tick;            /* tick in which the operator starts the task */
} kinematic_loop_config_t;

/* State at the beginning of a tick, and the command sent in that tick. */
typedef struct {
    control_mode_t mode;
    double position_rad[ARM_MAX_JOINTS];
    float command_radps[ARM_MAX_JOINTS];
} kinematic_tick_t;

/* Runs tick_count ticks; tick k is at k ms. start_rad has joint_count values. Writes one element of `ticks` per tick.
 * Returns true if all ticks were run. Ends early and returns false if a frame does not fit into the firmware's inbox,
 * or if the firmware refuses to select or start the task. */
bool kinematic_loop_run(const kinematic_loop_config_t *config, const double start_rad[], size_t sample_count,
                        const kinematic_sample_t samples[], size_t tick_count, kinematic_tick_t ticks[]);

#endif
