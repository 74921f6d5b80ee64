/* One tick of the firmware: frames in, frames out.
 *
 *   receive -> hand -> Algorithm 1 and task -> inverse kinematics -> limits -> send, watched by the supervisor
 *
 * On CAN FD a tick is 1 ms, on classic CAN 4 ms.
 *
 * A pure function of the state, the time, the frames received and the outcome of a save: the same log gives the same
 * bytes on every target. */
#ifndef COMANIP_CONTROLLER_H
#define COMANIP_CONTROLLER_H

#include "controller_state.h"

/* ik, with its arm, must outlive the controller. */
void controller_init(controller_t *self, const arm_ik_t *ik, can_profile_t profile);

/* Before the first step: parameters in place of the defaults. result: what the boot announcement says of them,
 * RESULT_ACCEPTED, or RESULT_STORE_FAILED if a stored record was not valid. */
void controller_set_parameters(controller_t *self, const parameters_t *parameters, result_t result);

/* now_us: monotonic modulo 2^32, one tick after the last call. inbox: the frames received since then, oldest first;
 * their contents are reassembled in place. A frame stamped after now_us, as one that arrived while the inbox was being
 * filled, is treated as received at now_us. outbox: its sink gets the frames to send, in that order; `save` is set. */
void controller_step(controller_t *self, uint32_t now_us, controller_inbox_t *inbox, controller_outbox_t *outbox);

#endif
