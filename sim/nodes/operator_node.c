#include "operator_node.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../firmware/parameters/parameters.h"
#include "../bus/endpoint.h"
#include "../common/names.h"
#include "../scenario/step_wait.h"
#include "comanip_tasks.h"

#define TEXT_BYTES 160
#define REFUSAL_BYTES 420  /* room for ten parameters with their values */
#define NAMING_NS 10000000 /* timeout for the next parameter of an unstable set; the firmware sends one per tick */
#define CLOSING_STEPS 2
#define LISTENS_TO                                                                                                     \
    (ENDPOINT_KIND(FRAME_FIRMWARE_STATUS) | ENDPOINT_KIND(FRAME_COMMAND_ACK) | ENDPOINT_KIND(FRAME_PARAMETER_VALUE) |  \
     ENDPOINT_KIND(FRAME_GRIPPER_STATE))

struct operator_node {
    endpoint_t endpoint;
    events_t *events;
    operator_step_t *steps; /* the script's steps, then CLOSING_STEPS more */
    size_t script_count;
    size_t current;
    int64_t ready_ns;   /* end of the previous step */
    bool stops;         /* operator_node_stop() has been called */
    int send_count;     /* how many times the current step's frame has been sent */
    int64_t due_ns;     /* when the current step became due; valid if `begun` */
    int64_t timeout_ns; /* when to send again */
    bool begun;
    uint8_t sequence;
    control_mode_t mode;
    reason_t reason;
    task_id_t task;
    bool latched;
    task_form_t custom_form;      /* form of the task defined last */
    char refusal[REFUSAL_BYTES];  /* text of the refusal; "": none */
    int64_t refusal_ns, named_ns; /* arrival times of the refusal and of the last parameter that was added to it */
    bool failed;
    char failure[REFUSAL_BYTES + 2 * TEXT_BYTES];
};

static int64_t ns_from_s(double seconds) {
    return (int64_t)(seconds * 1e9 + 0.5);
}

static void describe(const operator_step_t *step, char text[], size_t size) {
    text[0] = '\0';
    switch (step->action) {
    case OPERATOR_WRITE_PARAMETER:
        (void)snprintf(text, size, "writing parameter %s = %g", parameter_table[step->parameter].name,
                       (double)step->value);
        break;
    case OPERATOR_COMMAND:
    case OPERATOR_DEFINE_TASK:
        (void)snprintf(text, size, "command %s%s%s", command_name((uint8_t)step->command),
                       step->command == COMMAND_SELECT ? " " : "",
                       step->command == COMMAND_SELECT ? task_name((uint8_t)step->task) : "");
        break;
    case OPERATOR_MOVE_GRIPPER: (void)snprintf(text, size, "gripper command %s", step->close ? "close" : "open"); break;
    case OPERATOR_AWAIT_MODE: (void)snprintf(text, size, "waiting for mode %s", mode_name((uint8_t)step->mode)); break;
    }
}

static void fail(operator_node_t *self, int64_t now_ns, const char *what) {
    char step[TEXT_BYTES];
    describe(&self->steps[self->current], step, sizeof step);
    self->failed = true;
    (void)snprintf(self->failure, sizeof self->failure, "operator: %s at %.3f s: %s", step, (double)now_ns * 1e-9,
                   what);
}

static size_t step_count(const operator_node_t *self) {
    return self->script_count + CLOSING_STEPS;
}

static void finish_step(operator_node_t *self, int64_t now_ns) {
    const operator_step_t *step = &self->steps[self->current];
    if (step->action == OPERATOR_DEFINE_TASK) {
        self->custom_form = (task_form_t)step->define.form;
    }
    events_raise(self->events, step->done_event, (double)now_ns * 1e-9);
    const bool leaves_rest = self->stops && self->current < self->script_count;
    self->current = leaves_rest ? self->script_count : self->current + 1;
    self->ready_ns = now_ns;
    self->begun = false;
    self->send_count = 0;
}

/* Handles an answer to the current step's frame. */
static void on_result(operator_node_t *self, uint8_t sequence, result_t result, int64_t now_ns) {
    if (self->send_count == 0 || sequence != self->sequence) {
        return; /* a value published at boot, or a second answer to an earlier frame */
    }
    if (result == RESULT_ACCEPTED) {
        finish_step(self, now_ns);
    } else {
        (void)snprintf(self->refusal, sizeof self->refusal, "refused by the firmware: %s (mode %s)",
                       result_name((uint8_t)result), mode_name((uint8_t)self->mode));
        self->refusal_ns = self->named_ns = now_ns;
        if (result != RESULT_PARAMETERS_UNSTABLE) {
            fail(self, now_ns, self->refusal);
        }
    }
}

/* After the firmware has refused an unstable set of parameters, it sends one frame for each parameter that is involved.
 * Appends this frame's parameter to the text of the refusal. Ignores all other frames. */
static void add_to_refusal(operator_node_t *self, const parameter_value_t *value, int64_t now_ns) {
    if (self->refusal[0] == '\0' || value->sequence != self->sequence || value->result != RESULT_PARAMETERS_UNSTABLE ||
        value->parameter >= PARAMETER_COUNT) {
        return;
    }
    const char *separator = self->named_ns == self->refusal_ns ? ": " : ", ";
    self->named_ns = now_ns;
    const size_t used = strlen(self->refusal);
    (void)snprintf(self->refusal + used, sizeof self->refusal - used, "%s%s = %g", separator,
                   parameter_table[value->parameter].name, (double)value->value);
}

static bool awaits(const operator_node_t *self, operator_action_t action) {
    return !self->failed && self->current < step_count(self) && self->steps[self->current].action == action;
}

static void on_message(void *context, frame_kind_t kind, const can_frame_t *message, int64_t end_ns) {
    operator_node_t *self = context;
    if (kind == FRAME_FIRMWARE_STATUS) {
        firmware_status_t status;
        firmware_status_unpack(message, &status);
        self->mode = status.mode;
        self->reason = status.reason;
        self->task = status.task;
        self->latched = status.latched;
    } else if (kind == FRAME_COMMAND_ACK && (awaits(self, OPERATOR_COMMAND) || awaits(self, OPERATOR_DEFINE_TASK))) {
        command_ack_t ack;
        command_ack_unpack(message, &ack);
        if (ack.command == (uint8_t)self->steps[self->current].command) {
            on_result(self, ack.sequence, ack.result, end_ns);
        }
    } else if (kind == FRAME_PARAMETER_VALUE) {
        parameter_value_t value;
        parameter_value_unpack(message, &value);
        if (awaits(self, OPERATOR_WRITE_PARAMETER) && value.parameter == self->steps[self->current].parameter) {
            on_result(self, value.sequence, value.result, end_ns);
        } else {
            add_to_refusal(self, &value, end_ns);
        }
    } else if (kind == FRAME_GRIPPER_STATE && awaits(self, OPERATOR_MOVE_GRIPPER)) {
        gripper_state_t state;
        gripper_state_unpack(message, &state);
        on_result(self, state.sequence, RESULT_ACCEPTED, end_ns);
    }
}

operator_node_t *operator_node_create(bus_t *bus, events_t *events, const operator_step_t steps[], size_t count) {
    operator_node_t *self = calloc(1, sizeof *self);
    operator_step_t *copy = calloc(count + CLOSING_STEPS, sizeof *copy);
    if (self == NULL || copy == NULL) {
        free(self);
        free(copy);
        return NULL;
    }
    for (size_t i = 0; i < count; i++) {
        copy[i] = steps[i];
    }
    copy[count] = (operator_step_t){OPERATOR_COMMAND, .command = COMMAND_STOP, .done_event = EVENT_NONE};
    copy[count + 1] = (operator_step_t){OPERATOR_AWAIT_MODE, .mode = MODE_READY, .done_event = EVENT_NONE,
                                        .mode_timeout_s = OPERATOR_STOP_TIMEOUT_S};
    self->events = events;
    self->steps = copy;
    self->script_count = count;
    endpoint_attach(&self->endpoint, bus, ROBOT_JOINTS, LISTENS_TO, on_message, self);
    return self;
}

void operator_node_destroy(operator_node_t *self) {
    if (self != NULL) {
        free(self->steps);
        free(self);
    }
}

static protocol_status_t pack_step(const operator_step_t *step, uint8_t sequence, can_frame_t *frame) {
    if (step->action == OPERATOR_WRITE_PARAMETER) {
        const parameter_access_t access = {
            .operation = PARAMETER_WRITE, .parameter = step->parameter, .sequence = sequence, .value = step->value};
        return parameter_access_pack(&access, frame);
    }
    if (step->action == OPERATOR_DEFINE_TASK) {
        task_define_t define = step->define;
        define.sequence = sequence;
        return task_define_pack(&define, frame);
    }
    if (step->action == OPERATOR_MOVE_GRIPPER) {
        const gripper_command_t command = {.action = step->close ? GRIPPER_CLOSE : GRIPPER_OPEN, .sequence = sequence};
        return gripper_command_pack(&command, frame);
    }
    const operator_command_t command = {
        .command = (uint8_t)step->command, .sequence = sequence, .task = (uint8_t)step->task};
    return operator_command_pack(&command, frame);
}

/* Sends the current step's frame; a repetition carries the same sequence number, so that a late answer is accepted. */
static void send_step(operator_node_t *self, int64_t ready_ns) {
    const operator_step_t *step = &self->steps[self->current];
    if (self->send_count == 0) {
        self->sequence = self->sequence == UINT8_MAX ? 1 : (uint8_t)(self->sequence + 1);
    }
    can_frame_t frame;
    if (pack_step(step, self->sequence, &frame) != PROTOCOL_OK) {
        fail(self, ready_ns, "a value is outside the range of its CAN signal");
        return;
    }
    endpoint_send(&self->endpoint, &frame, ready_ns); /* if a full queue drops the frame, no answer arrives */
    self->send_count++;
    self->timeout_ns = ready_ns + ns_from_s(OPERATOR_ACK_TIMEOUT_S);
}

static void await_mode(operator_node_t *self, int64_t now_ns) {
    const operator_step_t *step = &self->steps[self->current];
    /* Idle also counts as stopped, because without a tracker the firmware changes from ready to idle at once. */
    const bool is_stopped = self->current >= self->script_count && self->mode == MODE_IDLE;
    if (self->mode == step->mode || is_stopped) {
        finish_step(self, now_ns);
    } else if (now_ns - self->due_ns > ns_from_s(step->mode_timeout_s)) {
        char what[TEXT_BYTES];
        (void)snprintf(what, sizeof what, "mode is still %s (%s) after %g s", mode_name((uint8_t)self->mode),
                       reason_name((uint8_t)self->reason), step->mode_timeout_s);
        fail(self, now_ns, what);
    }
}

static void await_answer(operator_node_t *self, int64_t from_ns, int64_t until_ns) {
    if (self->timeout_ns >= until_ns) {
        return;
    }
    if (self->send_count > OPERATOR_RETRIES) {
        const bool asks_gripper = self->steps[self->current].action == OPERATOR_MOVE_GRIPPER;
        char what[TEXT_BYTES];
        (void)snprintf(what, sizeof what, "no answer from the %s to %d attempts, %g ms each",
                       asks_gripper ? "gripper" : "firmware", OPERATOR_RETRIES + 1, 1e3 * OPERATOR_ACK_TIMEOUT_S);
        fail(self, from_ns, what);
    } else {
        send_step(self, self->timeout_ns > from_ns ? self->timeout_ns : from_ns);
    }
}

static bool is_due(const operator_node_t *self, size_t index, int64_t until_ns, int64_t *due_ns) {
    const operator_step_t *step = &self->steps[index];
    double begin_s;
    if (!step_wait_begin_s(&step->start, self->events, (double)self->ready_ns * 1e-9, &begin_s) ||
        (step->in_cooperation && self->mode != MODE_COOPERATING)) {
        return false;
    }
    *due_ns = ns_from_s(begin_s);
    return *due_ns < until_ns;
}

/* If the current step has gives_way set and is not due, but the next step is, swaps the two steps. */
static void choose_step(operator_node_t *self, int64_t until_ns) {
    const size_t next = self->current + 1;
    int64_t due_ns;
    if (next < self->script_count && self->steps[self->current].gives_way &&
        !is_due(self, self->current, until_ns, &due_ns) && is_due(self, next, until_ns, &due_ns)) {
        const operator_step_t deferred = self->steps[self->current];
        self->steps[self->current] = self->steps[next];
        self->steps[next] = deferred;
    }
}

/* Begins the current step if it is due. Returns true if it has begun. */
static bool begin_step(operator_node_t *self, int64_t from_ns, int64_t until_ns) {
    choose_step(self, until_ns);
    int64_t due_ns;
    if (is_due(self, self->current, until_ns, &due_ns)) {
        self->begun = true;
        self->due_ns = due_ns > from_ns ? due_ns : from_ns;
        return true;
    }
    char waited[TEXT_BYTES];
    if (step_wait_timed_out(&self->steps[self->current].start, self->events, (double)self->ready_ns * 1e-9,
                            (double)from_ns * 1e-9, waited, sizeof waited)) {
        fail(self, from_ns, waited);
    }
    return false;
}

void operator_node_step(operator_node_t *self, int64_t from_ns, int64_t until_ns) {
    const size_t end = self->stops ? step_count(self) : self->script_count;
    if (self->failed || self->current >= end || (!self->begun && !begin_step(self, from_ns, until_ns))) {
        return;
    }
    if (self->refusal[0] != '\0') {
        if (from_ns - self->named_ns > NAMING_NS) {
            fail(self, self->refusal_ns, self->refusal);
        }
    } else if (self->steps[self->current].action == OPERATOR_AWAIT_MODE) {
        await_mode(self, from_ns);
    } else if (self->send_count == 0) {
        send_step(self, self->due_ns);
    } else {
        await_answer(self, from_ns, until_ns);
    }
}

void operator_node_stop(operator_node_t *self) {
    self->stops = true;
    if (self->current < self->script_count && self->send_count == 0) {
        self->current = self->script_count;
        self->begun = false;
    }
}

void operator_node_describe(const operator_node_t *self, char text[], size_t size) {
    if (operator_node_script_done(self)) {
        (void)snprintf(text, size, "operator is done");
        return;
    }
    const operator_step_t *step = &self->steps[self->current];
    const char *missing = step_wait_missing(&step->start, self->events);
    char what[TEXT_BYTES];
    describe(step, what, sizeof what);
    (void)snprintf(text, size, "operator %s %s", missing != NULL ? "waits for" : "is at",
                   missing != NULL ? missing : what);
}

bool operator_node_script_done(const operator_node_t *self) {
    return self->current >= self->script_count;
}

bool operator_node_finished(const operator_node_t *self) {
    return self->current == step_count(self);
}

static task_form_t form_in_force(const operator_node_t *self) {
    switch (self->task) {
#define CASE(NAME, number, name, form, t_task, q_task, q_inv)                                                          \
    case TASK_##NAME: return TASK_FORM_##form;
        COMANIP_TASKS(CASE)
    case TASK_CUSTOM: return self->custom_form;
    }
    return TASK_FORM_CONSTANT;
}

bool operator_node_mirrors(const operator_node_t *self) {
    return form_in_force(self) == TASK_FORM_MIRRORED && !self->latched;
}

const char *operator_node_failure(const operator_node_t *self) {
    return self->failed ? self->failure : NULL;
}
