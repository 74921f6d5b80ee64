/* Handles the operator's requests: select, define, start, latch, clutch, stop. For parameters, see
 * controller_parameters.h. */
#ifndef COMANIP_CONTROLLER_REQUESTS_H
#define COMANIP_CONTROLLER_REQUESTS_H

#include "controller_state.h"

/* Selects a task. While cooperating, the new task replaces the previous one gradually over blend_s. */
void controller_select_task(controller_t *self, task_id_t id, const task_t *task, float blend_s);

/* Executes and answers this tick's requests. A save is answered later, when it has ended. */
void controller_handle_requests(controller_t *self, const controller_inbox_t *inbox, controller_outbox_t *outbox);

#endif
