/* The operator as a node on the bus: works through a script of steps, each at its time or after events. Every command,
 * parameter write and gripper command must be acknowledged; a silent receiver is asked again, a refusal or silence
 * after all fails the run with a reason. At the end the operator stops the arm, whatever has been done by then. */
#ifndef COMANIP_SIM_OPERATOR_NODE_H
#define COMANIP_SIM_OPERATOR_NODE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "../../firmware/protocol/can_protocol.h"
#include "../bus/bus.h"
#include "../scenario/scenario.h"

#define OPERATOR_ACK_TIMEOUT_S 0.050
#define OPERATOR_RETRIES 3
#define OPERATOR_STOP_PATIENCE_S (0.8 * SCENARIO_STOP_BEFORE_END_S)

typedef enum {
    OPERATOR_WRITE_PARAMETER,
    OPERATOR_COMMAND,
    OPERATOR_DEFINE_TASK,
    OPERATOR_MOVE_GRIPPER,
    OPERATOR_AWAIT_MODE,
} operator_action_t;

typedef struct {
    operator_action_t action;
    step_start_t start;  /* and after the step before */
    bool in_cooperation; /* and not before the arm cooperates */
    bool gives_way;      /* to the next step, where that is due first */
    int done_event;      /* raised when it is acknowledged; EVENT_NONE */
    uint8_t parameter;   /* OPERATOR_WRITE_PARAMETER */
    float value;
    command_t command; /* OPERATOR_COMMAND; OPERATOR_DEFINE_TASK: COMMAND_DEFINE, as it is acknowledged */
    task_id_t task;
    task_define_t define;   /* OPERATOR_DEFINE_TASK; its sequence is the node's */
    bool close;             /* OPERATOR_MOVE_GRIPPER */
    control_mode_t mode;    /* OPERATOR_AWAIT_MODE */
    double mode_patience_s; /* how long to wait for it */
} operator_step_t;

typedef struct operator_node operator_node_t;

/* Copies the steps; the bus and the events must outlive the node. NULL: no memory. */
operator_node_t *operator_node_create(bus_t *bus, events_t *events, const operator_step_t steps[], size_t count);
void operator_node_destroy(operator_node_t *self);

/* Queues what falls due in [from_ns, until_ns). */
void operator_node_step(operator_node_t *self, int64_t from_ns, int64_t until_ns);

/* From now on: the stop command, and the wait for mode ready. A step whose frame is on its way is finished before, what
 * has not begun is left out. */
void operator_node_stop(operator_node_t *self);

/* All steps of the script are done, or left out. */
bool operator_node_script_done(const operator_node_t *self);

/* What the operator is about: "operator waits for person.holds", "operator is done", or the step by its name. */
void operator_node_describe(const operator_node_t *self, char text[], size_t size);

/* The stop, too. */
bool operator_node_finished(const operator_node_t *self);

/* The task in force mirrors the person's motion along the torso's x axis; a latch ends that. */
bool operator_node_mirrors(const operator_node_t *self);

/* NULL, or one line that names the command, its time and what went wrong. */
const char *operator_node_failure(const operator_node_t *self);

#endif
