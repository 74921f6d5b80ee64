/* The joint velocities demanded in a tick: Algorithm 1, then inverse kinematics. */
#ifndef COMANIP_CONTROLLER_DEMAND_H
#define COMANIP_CONTROLLER_DEMAND_H

#include "controller_state.h"

/* How far the selected task has come into force, 0 to 1 with minimum jerk. */
float controller_task_blend(const controller_t *self);

/* The demand at a target that is the end effector's own pose: no feedback; feedforward of the target's motion goes on.
 */
void controller_zero_feedback(controller_t *self);

/* No motion at all. */
void controller_zero_demand(controller_t *self);

/* Sets self->feedback_radps and self->feedforward_radps; both are 0 unless cooperating. */
void controller_compute_demand(controller_t *self, uint32_t now_us);

#endif
