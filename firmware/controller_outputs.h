/* The frames that the controller sends. */
#ifndef COMANIP_CONTROLLER_OUTPUTS_H
#define COMANIP_CONTROLLER_OUTPUTS_H

#include "controller_state.h"

/* Sends a frame with end-to-end protection. On classic CAN, a frame with a value out of range is not sent. */
void controller_send(controller_t *self, can_frame_t *frame, controller_outbox_t *outbox);

/* Send the answer to a request. sequence: the request's sequence number. */
void controller_send_ack(controller_t *self, uint8_t command, uint8_t sequence, result_t result,
                         controller_outbox_t *outbox);
void controller_send_parameter(controller_t *self, uint8_t parameter, uint8_t sequence, result_t result,
                               controller_outbox_t *outbox);

/* Sends the joint command, as well as the trace, status, port status and heartbeat if they are due in this tick. */
void controller_publish(controller_t *self, uint32_t now_us, const port_status_t *port, controller_outbox_t *outbox);

#endif
