/* Handles the operator's requests: see controller_requests.h. */
#include "controller_requests.h"

#include <stddef.h>

#include "controller_demand.h"
#include "controller_outputs.h"
#include "controller_parameters.h"

#define UNIT_TOLERANCE 1e-3f

/* Returns the end effector's measured pose in the torso frame. */
static pose_t measured_pose(const controller_t *self) {
    return self->arm->forward_kinematics(self->arm, self->measured_rad);
}

/* ---- tasks */

void controller_select_task(controller_t *self, task_id_t id, const task_t *task, float blend_s) {
    self->task_id = id;
    self->task = *task;
    self->blend_s = blend_s;
    self->blend_elapsed_s = 0.0f;
    if (supervisor_is_engaged(&self->supervisor)) {
        cooperation_select(&self->cooperation, task);
        self->cooperation_changed = true;
    }
}

static result_t select_built_in(controller_t *self, uint8_t number) {
    const task_t *task = task_built_in(number);
    if (task == NULL) {
        return RESULT_UNKNOWN_TASK;
    }
    controller_select_task(self, (task_id_t)number, task, self->parameters.value[PARAMETER_TASK_BLEND_S]);
    return RESULT_ACCEPTED;
}

static result_t define_task(controller_t *self, const task_define_t *define) {
    if (define->form > TASK_FORM_MIRRORED) {
        return RESULT_OUT_OF_RANGE;
    }
    if (!quaternion_is_unit(define->q_task, UNIT_TOLERANCE) || !quaternion_is_unit(define->q_inv, UNIT_TOLERANCE)) {
        return RESULT_NOT_A_UNIT_QUATERNION;
    }
    task_t task = {
        .form = (task_form_t)define->form,
        .t_task_m = define->t_task_m,
        .q_task = quaternion_normalise(define->q_task),
        .q_inv = quaternion_normalise(define->q_inv),
    };
    controller_select_task(self, TASK_CUSTOM, &task, define->blend_s);
    return RESULT_ACCEPTED;
}

/* ---- cooperation */

static result_t start(controller_t *self, uint8_t sequence) {
    const result_t refusal = controller_require_stable(self, sequence);
    result_t result =
        refusal != RESULT_ACCEPTED ? refusal : supervisor_start(&self->supervisor, &self->supervisor_inputs);
    if (result == RESULT_ACCEPTED) {
        self->blend_elapsed_s = 0.0f;
        cooperation_start(&self->cooperation, &self->cooperation_config, &self->task, self->hand, measured_pose(self));
        self->cooperation_changed = true;
        controller_zero_demand(self);
    }
    return result;
}

/* Latch and clutch need the pose of the person's hand, so they are refused in mode hold. */
static result_t require_cooperating(const controller_t *self) {
    switch (self->supervisor.mode) {
    case MODE_COOPERATING: return RESULT_ACCEPTED;
    case MODE_HOLD: return RESULT_TRACKER_STALE;
    default: return RESULT_WRONG_MODE;
    }
}

static result_t latch(controller_t *self) {
    result_t result = require_cooperating(self);
    if (result == RESULT_ACCEPTED) {
        if (self->parameters.value[PARAMETER_LATCH_MEASURED] > 0.0f) {
            /* update first, so that the relation is measured with this tick's virtual hand */
            cooperation_update(&self->cooperation, &self->hand, controller_task_blend(self));
            cooperation_latch_measured(&self->cooperation, measured_pose(self));
            controller_zero_feedback(self);
        } else {
            cooperation_latch(&self->cooperation);
        }
        self->cooperation_changed = true;
    }
    return result;
}

static result_t clutch(controller_t *self) {
    result_t result = require_cooperating(self);
    if (result == RESULT_ACCEPTED) {
        cooperation_clutch(&self->cooperation, self->hand, measured_pose(self), controller_task_blend(self));
        self->cooperation_changed = true;
        controller_zero_feedback(self);
    }
    return result;
}

/* ---- requests */

static result_t execute(controller_t *self, const operator_command_t *command) {
    switch (command->command) {
    case COMMAND_SELECT: return select_built_in(self, command->task);
    case COMMAND_START: return start(self, command->sequence);
    case COMMAND_LATCH: return latch(self);
    case COMMAND_CLUTCH: return clutch(self);
    case COMMAND_STOP: return supervisor_stop(&self->supervisor);
    case COMMAND_ACKNOWLEDGE: return supervisor_acknowledge(&self->supervisor, &self->supervisor_inputs);
    default: return RESULT_UNKNOWN_COMMAND;
    }
}

void controller_handle_requests(controller_t *self, const controller_inbox_t *inbox, controller_outbox_t *outbox) {
    for (uint8_t i = 0; i < self->request_count; i++) {
        const can_frame_t *frame = &inbox->frame[self->request[i].index];
        if (self->request[i].kind == FRAME_OPERATOR_COMMAND) {
            operator_command_t command;
            operator_command_unpack(frame, &command);
            controller_send_ack(self, command.command, command.sequence, execute(self, &command), outbox);
        } else if (self->request[i].kind == FRAME_TASK_DEFINE) {
            task_define_t define;
            task_define_unpack(frame, &define);
            controller_send_ack(self, COMMAND_DEFINE, define.sequence, define_task(self, &define), outbox);
        } else {
            parameter_access_t access;
            parameter_access_unpack(frame, &access);
            controller_access_parameter(self, &access, outbox);
        }
    }
}
