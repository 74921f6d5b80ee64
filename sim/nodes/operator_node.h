/* The operator as a node on the bus. It executes a script of steps. Each step is due at a given time or after certain
 * events. Every command, parameter write and gripper command must be acknowledged; the node repeats a frame that is not
 * answered. If a frame is refused, or is still unanswered after all retries, the run fails with a reason. After the
 * script, the operator stops the arm, whether or not the script itself stops it. */
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
#define OPERATOR_STOP_TIMEOUT_S (0.8 * SCENARIO_STOP_BEFORE_END_S)

typedef enum {
    OPERATOR_WRITE_PARAMETER,
    OPERATOR_COMMAND,
    OPERATOR_DEFINE_TASK,
    OPERATOR_MOVE_GRIPPER,
    OPERATOR_AWAIT_MODE,
} operator_action_t;

typedef struct {
    operator_action_t action;
    step_start_t start;  /* in addition, the step waits for the end of the previous step */
    bool in_cooperation; /* the step waits until the arm cooperates */
    bool gives_way;      /* if the next step becomes due before this step, the next step is executed first */
    int done_event;      /* event that the step raises when it is acknowledged; EVENT_NONE: no event */
    uint8_t parameter;   /* for OPERATOR_WRITE_PARAMETER */
    float value;
    command_t command; /* for OPERATOR_COMMAND; for OPERATOR_DEFINE_TASK: COMMAND_DEFINE, as in the CommandAck */
    task_id_t task;
    task_define_t define;  /* for OPERATOR_DEFINE_TASK; the node fills in the sequence number */
    bool close;            /* for OPERATOR_MOVE_GRIPPER */
    control_mode_t mode;   /* for OPERATOR_AWAIT_MODE */
    double mode_timeout_s; /* how long to wait for `mode` */
} operator_step_t;

typedef struct operator_node operator_node_t;

/* Copies the steps; the bus and the events must outlive the node. Returns NULL if out of memory. */
operator_node_t *operator_node_create(bus_t *bus, events_t *events, const operator_step_t steps[], size_t count);
void operator_node_destroy(operator_node_t *self);

/* Queues the frames that are due in [from_ns, until_ns). */
void operator_node_step(operator_node_t *self, int64_t from_ns, int64_t until_ns);

/* Ends the script: sends the stop command and waits for mode ready. A step whose frame has been sent is finished first;
 * steps that have not begun are skipped. */
void operator_node_stop(operator_node_t *self);

/* Returns true if all steps of the script are done or skipped. */
bool operator_node_script_done(const operator_node_t *self);

/* Describes the current step, for example "operator waits for person.holds", "operator is at command start" or
 * "operator is done". */
void operator_node_describe(const operator_node_t *self, char text[], size_t size);

/* Returns true if the script is done and the arm has been stopped after it. */
bool operator_node_finished(const operator_node_t *self);

/* Returns true if the active task mirrors the person's motion along the torso's x axis. The latch command
 * ends the mirroring. */
bool operator_node_mirrors(const operator_node_t *self);

/* Returns NULL if nothing failed, otherwise one line that names the command, its time and what went wrong. */
const char *operator_node_failure(const operator_node_t *self);

#endif
