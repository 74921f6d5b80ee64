/* What a tick begins with: the frames received, the person's hand, and the mode that follows from both. */
#ifndef COMANIP_CONTROLLER_INPUTS_H
#define COMANIP_CONTROLLER_INPUTS_H

#include "controller_state.h"

/* Takes over all measurements; operator requests are only noted, as they need this tick's poses. */
void controller_receive(controller_t *self, uint32_t now_us, controller_inbox_t *inbox);

/* Sets self->hand. */
void controller_update_hand(controller_t *self, uint32_t now_us);

/* Checks that drives and tracker are fresh, and updates the mode. */
void controller_supervise(controller_t *self, uint32_t now_us);

#endif
