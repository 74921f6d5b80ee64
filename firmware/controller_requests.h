/* The operator's requests: select, define, start, latch, clutch, stop. Parameters are in controller_parameters.h. */
#ifndef COMANIP_CONTROLLER_REQUESTS_H
#define COMANIP_CONTROLLER_REQUESTS_H

#include "controller_state.h"

/* Selects a task. While cooperating, it replaces the previous task gradually over blend_s. */
void controller_select_task(controller_t *self, task_id_t id, const task_t *task, float blend_s);

/* Executes this tick's requests and answers them, except a save, which is answered when it has ended. */
void controller_handle_requests(controller_t *self, const controller_inbox_t *inbox, controller_outbox_t *outbox);

#endif
