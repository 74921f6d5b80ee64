/* The first stages of a tick: process the received frames, update the person's hand, and derive the mode. */
#ifndef COMANIP_CONTROLLER_INPUTS_H
#define COMANIP_CONTROLLER_INPUTS_H

#include "controller_state.h"

/* Processes all measurements. Stores the operator's requests, which are executed after this tick's poses have been
 * computed. */
void controller_receive(controller_t *self, uint32_t now_us, controller_inbox_t *inbox);

/* Sets self->hand and self->lever_m. */
void controller_update_hand(controller_t *self, uint32_t now_us);

/* Checks whether the data from drives and tracker are fresh, and updates the mode. */
void controller_supervise(controller_t *self, uint32_t now_us);

#endif
