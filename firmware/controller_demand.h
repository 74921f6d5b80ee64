/* Computes the joint velocities that Algorithm 1 and inverse kinematics demand in a tick. */
#ifndef COMANIP_CONTROLLER_DEMAND_H
#define COMANIP_CONTROLLER_DEMAND_H

#include "controller_state.h"

/* Returns the weight of the selected task in the blend from the previous task, from 0 (only the previous task) to 1
 * (only the selected task). The weight follows a minimum-jerk profile over blend_s. */
float controller_task_blend(const controller_t *self);

/* Sets the feedback to 0, as if the end effector were at its target. Keeps the feedforward of the target's motion. */
void controller_zero_feedback(controller_t *self);

/* Sets feedback and feedforward to 0. */
void controller_zero_demand(controller_t *self);

/* Sets self->feedback_radps and self->feedforward_radps; both are 0 unless cooperating. */
void controller_compute_demand(controller_t *self, uint32_t now_us);

#endif
