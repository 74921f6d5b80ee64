/* The firmware in a loop without physics, some hundred times faster than real time: controller_step() over frames on
 * CAN FD, drives that follow their commands with a lag, encoders. The order of events within a tick is the simulator's
 * (sim/world/world.c): a command acts from its tick on; what the encoders read at that tick arrives for the next one. */
#ifndef COMANIP_KINEMATIC_LOOP_H
#define COMANIP_KINEMATIC_LOOP_H

#include <stddef.h>

#include "../../../firmware/controller.h"

/* ---- the arm: joints behind the lag of their drives */

typedef struct {
    int joint_count;
    double lag_s; /* time constant of the velocity servo */
    double position_rad[ARM_MAX_JOINTS];
    double velocity_radps[ARM_MAX_JOINTS];
} kinematic_arm_t;

/* start_rad: joint_count values. */
void kinematic_arm_init(kinematic_arm_t *self, int joint_count, double lag_s, const double start_rad[]);

/* One tick of 1 ms. command_radps, encoder_rad: joint_count values; the encoders are read at the tick's beginning. */
void kinematic_arm_step(kinematic_arm_t *self, const float command_radps[], float encoder_rad[]);

/* ---- the firmware around it */

/* One HandPose on the bus. */
typedef struct {
    uint32_t received_us; /* by the firmware's clock: the end of the frame; ascending */
    hand_pose_t pose;
} kinematic_sample_t;

typedef struct {
    const arm_ik_t *ik;
    parameters_t parameters;
    double lag_s;                   /* of the drives */
    uint32_t period_us, latency_us; /* as TrackerStatus announces them, 10 times a second */
    uint8_t task;                   /* that the operator selects, task_id_t */
    uint32_t start_tick;            /* in which he starts it */
} kinematic_loop_config_t;

/* At a tick's beginning, and what was commanded then. */
typedef struct {
    control_mode_t mode;
    double position_rad[ARM_MAX_JOINTS];
    float command_radps[ARM_MAX_JOINTS];
} kinematic_tick_t;

/* Tick k is at k ms. start_rad: the arm's joint_count values; ticks: tick_count, written. False: the firmware refused a
 * frame, a parameter or the start. */
bool kinematic_loop_run(const kinematic_loop_config_t *config, const double start_rad[], size_t sample_count,
                        const kinematic_sample_t samples[], size_t tick_count, kinematic_tick_t ticks[]);

#endif
