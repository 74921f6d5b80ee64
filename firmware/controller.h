/* One tick of the firmware: frames in, frames out.
 *
 *   receive -> hand -> Algorithm 1 and task -> inverse kinematics -> limits -> send, monitored by the supervisor
 *
 * On CAN FD a tick is 1 ms, on classic CAN 4 ms.
 *
 * A tick is a pure function of the state, the time, the received frames and the outcome of a save, so the same log
 * yields the same bytes on every target. */
#ifndef COMANIP_CONTROLLER_H
#define COMANIP_CONTROLLER_H

#include "controller_state.h"

/* Initialises the controller. `ik` and its arm must outlive it. */
void controller_init(controller_t *self, const arm_ik_t *ik, can_profile_t profile);

/* Replaces the default parameters; call it before the first step. result: reported in the boot announcement. Must be
 * RESULT_STORE_FAILED if the stored record was not valid, otherwise RESULT_ACCEPTED. */
void controller_set_parameters(controller_t *self, const parameters_t *parameters, result_t result);

/* Runs one tick.
 *
 * now_us: the time, monotonic modulo 2^32, one tick after the time of the previous call. inbox: the frames received
 * since the previous call, oldest first; they are reassembled in place. A frame that arrived while the inbox was being
 * filled has a timestamp after now_us, and is treated as received at now_us. outbox: the sink receives the frames to
 * send, in order; the call sets the other members. */
void controller_step(controller_t *self, uint32_t now_us, controller_inbox_t *inbox, controller_outbox_t *outbox);

#endif
