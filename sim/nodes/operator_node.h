/* The operator as a node on the bus: works through a script of timed steps. Every command and parameter write must be
 * acknowledged; a silent firmware is asked again, a refusal or silence after all fails the run with a reason. */
#ifndef COMANIP_SIM_OPERATOR_NODE_H
#define COMANIP_SIM_OPERATOR_NODE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "../../firmware/can_protocol.h"
#include "../bus/bus.h"

#define OPERATOR_ACK_TIMEOUT_S 0.050
#define OPERATOR_RETRIES 3

typedef enum {
    OPERATOR_WRITE_PARAMETER,
    OPERATOR_COMMAND,
    OPERATOR_DEFINE_TASK,
    OPERATOR_AWAIT_MODE,
} operator_action_t;

typedef struct {
    operator_action_t action;
    double not_before_s; /* and after the step before */
    uint8_t parameter;   /* OPERATOR_WRITE_PARAMETER */
    float value;
    command_t command; /* OPERATOR_COMMAND; OPERATOR_DEFINE_TASK: COMMAND_DEFINE, as it is acknowledged */
    task_id_t task;
    task_define_t define; /* OPERATOR_DEFINE_TASK; its sequence is the node's */
    control_mode_t mode; /* OPERATOR_AWAIT_MODE */
    double patience_s;   /* how long to wait for it */
} operator_step_t;

typedef struct operator_node operator_node_t;

/* Copies the steps. */
operator_node_t *operator_node_create(bus_t *bus, const operator_step_t steps[], size_t count);
void operator_node_destroy(operator_node_t *self);

/* Queues what falls due in [from_ns, until_ns). */
void operator_node_step(operator_node_t *self, int64_t from_ns, int64_t until_ns);

bool operator_node_finished(const operator_node_t *self);

/* NULL, or one line that names the command, its time and what went wrong. */
const char *operator_node_failure(const operator_node_t *self);

#endif
