/* The boot announcement: the firmware's identity, then each parameter, one frame per tick. */
#ifndef COMANIP_CONTROLLER_ANNOUNCEMENT_H
#define COMANIP_CONTROLLER_ANNOUNCEMENT_H

#include "controller_state.h"

/* Sends the next frame of the announcement, if any is left. */
void controller_announce(controller_t *self, controller_outbox_t *outbox);

/* Sends one parameter's value, and reports whether the stored record was valid and whether the set of parameters is
 * stable. */
void controller_announce_parameter(controller_t *self, uint8_t parameter, controller_outbox_t *outbox);

#endif
