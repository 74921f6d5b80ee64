/* Applies the controller's parameters, and reads, writes and saves them over CAN. */
#ifndef COMANIP_CONTROLLER_PARAMETERS_H
#define COMANIP_CONTROLLER_PARAMETERS_H

#include "controller_state.h"

/* Derives all configurations from self->parameters. Must be called after every change. */
void controller_apply_parameters(controller_t *self);

/* Checks, before a start or a save, that the parameters together do not make the arm unstable. (Writing such a set is
 * allowed, because parameters are written one by one.) If this returns RESULT_PARAMETERS_UNSTABLE, the caller must
 * refuse the request; the parameters involved are then reported in the following ticks with the request's sequence
 * number. Otherwise returns RESULT_ACCEPTED. */
result_t controller_require_stable(controller_t *self, uint8_t sequence);

/* Reports the next of the parameters involved in a refusal, if any is left; call it once per tick. */
void controller_report_unstable(controller_t *self, controller_outbox_t *outbox);

/* Handles a request to read or write a parameter, or to save all parameters, and answers it. The answer to an accepted
 * save is sent by controller_finish_save() when the save has ended. */
void controller_access_parameter(controller_t *self, const parameter_access_t *access, controller_outbox_t *outbox);
void controller_finish_save(controller_t *self, const controller_inbox_t *inbox, controller_outbox_t *outbox);

#endif
