/* One tick of the firmware: frames in, frames out.
 *
 *   receive -> hand -> Algorithm 1 and task -> inverse kinematics -> limits -> send, monitored by the supervisor
 *
 * On CAN FD a tick is 1 ms, on classic CAN 4 ms.
 *
 * A tick is a pure function of the controller's state, the time and the inbox, so a replay of the same log yields the
 * same bytes on every target. */
#ifndef COMANIP_CONTROLLER_H
#define COMANIP_CONTROLLER_H

#include "controller_state.h"

/* Initialises the controller. `ik` and its arm must outlive the controller. */
void controller_init(controller_t *self, const arm_ik_t *ik, can_profile_t profile);

/* Replaces the default parameters; call this before the first step. result: the result that the boot announcement
 * reports, which must be RESULT_STORE_FAILED if the stored record was not valid, otherwise RESULT_ACCEPTED. */
void controller_set_parameters(controller_t *self, const parameters_t *parameters, result_t result);

/* Runs one tick.
 *
 * now_us: the time, monotonic modulo 2^32, normally one tick after the time of the previous call. inbox: the frames
 * received since the previous call, oldest first. On classic CAN, the call overwrites a frame that completes a message
 * with that message. A frame that arrived while the inbox was being filled has a timestamp after now_us, and is treated
 * as received at now_us. outbox: `sink` receives the frames to send, in order; the call sets the other members. */
void controller_step(controller_t *self, uint32_t now_us, controller_inbox_t *inbox, controller_outbox_t *outbox);

#endif
