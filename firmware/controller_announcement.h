/* What the firmware says of itself after boot: its identity, then each parameter, one frame in each tick. */
#ifndef COMANIP_CONTROLLER_ANNOUNCEMENT_H
#define COMANIP_CONTROLLER_ANNOUNCEMENT_H

#include "controller_state.h"

/* Sends what is next; when all has been sent, nothing. */
void controller_announce(controller_t *self, controller_outbox_t *outbox);

/* Sends one parameter: its value, and whether it was stored validly and is stable with the others. */
void controller_announce_parameter(controller_t *self, uint8_t parameter, controller_outbox_t *outbox);

#endif
