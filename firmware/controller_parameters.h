/* Applies the controller's parameters, and reads, writes and saves them over CAN. */
#ifndef COMANIP_CONTROLLER_PARAMETERS_H
#define COMANIP_CONTROLLER_PARAMETERS_H

#include "controller_state.h"

/* Derives all configurations from self->parameters. Call it after a change. */
void controller_apply_parameters(controller_t *self);

/* Parameters that together make the arm unstable may be written, but a start or a save with them is refused.
 * RESULT_PARAMETERS_UNSTABLE: the caller must refuse the request; the parameters involved are reported in the next
 * ticks with the request's sequence number. Otherwise RESULT_ACCEPTED. */
result_t controller_require_stable(controller_t *self, uint8_t sequence);

/* Reports the next of these parameters, one per tick. */
void controller_report_unstable(controller_t *self, controller_outbox_t *outbox);

/* Handles a request to read, write or save, and answers it. controller_finish_save() answers a save when it has ended.
 * */
void controller_access_parameter(controller_t *self, const parameter_access_t *access, controller_outbox_t *outbox);
void controller_finish_save(controller_t *self, const controller_inbox_t *inbox, controller_outbox_t *outbox);

#endif
