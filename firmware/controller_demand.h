/* The joint velocities demanded in a tick, by Algorithm 1 and inverse kinematics. */
#ifndef COMANIP_CONTROLLER_DEMAND_H
#define COMANIP_CONTROLLER_DEMAND_H

#include "controller_state.h"

/* The blend from the previous task (0) to the selected task (1), with minimum jerk. */
float controller_task_blend(const controller_t *self);

/* Sets the feedback to 0, as when the end effector is at its target. The feedforward of the target's motion stays. */
void controller_zero_feedback(controller_t *self);

/* Sets feedback and feedforward to 0. */
void controller_zero_demand(controller_t *self);

/* Sets self->feedback_radps and self->feedforward_radps; both are 0 unless cooperating. */
void controller_compute_demand(controller_t *self, uint32_t now_us);

#endif
