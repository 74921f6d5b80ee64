/* The controller's parameters: put into force, and read, written and saved over CAN. */
#ifndef COMANIP_CONTROLLER_PARAMETERS_H
#define COMANIP_CONTROLLER_PARAMETERS_H

#include "controller_state.h"

/* After a change of self->parameters: derives all configurations from them. */
void controller_apply_parameters(controller_t *self);

/* Parameters that make the arm unstable together may be written one by one, but neither started with nor saved.
 * RESULT_PARAMETERS_UNSTABLE: the request is to be refused; the parameters involved are reported in the next ticks,
 * with the request's sequence number. Else RESULT_ACCEPTED. */
result_t controller_require_stable(controller_t *self, uint8_t sequence);

/* One parameter of those, in each tick. */
void controller_report_unstable(controller_t *self, controller_outbox_t *outbox);

/* Answers a request to read, write or save; a save when it is over, by controller_finish_save(). */
void controller_access_parameter(controller_t *self, const parameter_access_t *access, controller_outbox_t *outbox);
void controller_finish_save(controller_t *self, const controller_inbox_t *inbox, controller_outbox_t *outbox);

#endif
