/* The operator's requests: select, define, start, latch, clutch, stop; parameters are in controller_parameters.h. */
#ifndef COMANIP_CONTROLLER_REQUESTS_H
#define COMANIP_CONTROLLER_REQUESTS_H

#include "controller_state.h"

/* While cooperating, the task comes into force over blend_s. */
void controller_select_task(controller_t *self, task_id_t id, const task_t *task, float blend_s);

/* Carries out this tick's requests, and answers each but a save in this tick. */
void controller_handle_requests(controller_t *self, const controller_inbox_t *inbox, controller_outbox_t *outbox);

#endif
