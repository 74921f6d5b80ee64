/* Applies, reads, writes and saves parameters: see controller_parameters.h. */
#include "controller_parameters.h"

#include <string.h>

#include "controller_announcement.h"
#include "controller_outputs.h"

void controller_apply_parameters(controller_t *self) {
    const float tick_s = controller_tick_s(self);
    parameters_differential_ik(&self->parameters, &self->differential_ik_config);
    parameters_position_priority(&self->parameters, &self->position_priority_config);
    parameters_joint_limits(&self->parameters, self->arm, tick_s, &self->joint_limits_config);
    parameters_cooperation(&self->parameters, &self->cooperation_config);
    self->marker_to_hand = parameters_marker_to_hand(&self->parameters);
    self->predicts = parameters_predict(&self->parameters);
    self->changes_posture = parameters_change_posture(&self->parameters);
    hand_tracker_interpolate(&self->hand_tracker, !self->predicts);
    if (!self->predicts) { /* if prediction is switched on again later, it starts afresh with the next sample */
        hand_motion_init(&self->marker_motion);
    }
    self->marker_is_hand = memcmp(&self->marker_to_hand, &pose_identity, sizeof pose_identity) == 0;
    self->parameter_set = parameter_set_check(&self->parameters, tick_s);
    self->unreported = 0;
}

/* ---- unstable sets of parameters */

result_t controller_require_stable(controller_t *self, uint8_t sequence) {
    if (self->parameter_set.verdict != PARAMETER_SET_UNSTABLE) {
        return RESULT_ACCEPTED;
    }
    self->unreported = self->parameter_set.involved;
    self->unreported_sequence = sequence;
    return RESULT_PARAMETERS_UNSTABLE;
}

/* The reports start in the tick after the refusal and are sent one per tick, to limit the bus load. */
void controller_report_unstable(controller_t *self, controller_outbox_t *outbox) {
    if (self->unreported == 0u) {
        return;
    }
    uint8_t parameter = 0;
    while ((self->unreported >> parameter & 1u) == 0u) {
        parameter++;
    }
    controller_send_parameter(self, parameter, self->unreported_sequence, RESULT_PARAMETERS_UNSTABLE, outbox);
    self->unreported &= self->unreported - 1u;
}

/* ---- read and write */

/* Parameters change only at rest. In motion, a new gain or a new tracker rotation would make the command jump. */
static bool may_change(const controller_t *self) {
    return !supervisor_is_engaged(&self->supervisor) && joint_limits_at_rest(&self->limits, self->arm);
}

static result_t read_or_write(controller_t *self, const parameter_access_t *access) {
    if (!parameters_has(access->parameter)) {
        return RESULT_UNKNOWN_PARAMETER;
    }
    if (access->operation == PARAMETER_READ) {
        return RESULT_ACCEPTED;
    }
    if (access->operation != PARAMETER_WRITE) {
        return RESULT_UNKNOWN_COMMAND;
    }
    if (!may_change(self)) {
        return RESULT_WRONG_MODE;
    }
    result_t result = parameters_set(&self->parameters, access->parameter, access->value);
    if (result == RESULT_ACCEPTED) {
        controller_apply_parameters(self);
    }
    return result;
}

/* ---- save */

/* A request with the sequence number of the save in progress repeats the request for that save, and is not answered
 * separately. Any other save is refused while a save is in progress, and whenever may_change() is false. */
static void begin_save(controller_t *self, const parameter_access_t *access, controller_outbox_t *outbox) {
    if (self->saving && access->sequence == self->save_sequence) {
        return;
    }
    const bool may_save = !self->saving && may_change(self);
    const result_t result = may_save ? controller_require_stable(self, access->sequence) : RESULT_WRONG_MODE;
    if (result != RESULT_ACCEPTED) {
        controller_send_parameter(self, access->parameter, access->sequence, result, outbox);
        return;
    }
    self->saving = true;
    self->save_parameter = access->parameter;
    self->save_sequence = access->sequence;
    outbox->save = true;
}

void controller_finish_save(controller_t *self, const controller_inbox_t *inbox, controller_outbox_t *outbox) {
    if (self->saving && inbox->save_over) {
        self->saving = false;
        controller_send_parameter(self, self->save_parameter, self->save_sequence, inbox->save_result, outbox);
    }
}

/* A parameter can be written before the boot announcement has reached it. Its present value is then announced first,
 * because a replay needs the value that applied at boot. */
void controller_access_parameter(controller_t *self, const parameter_access_t *access, controller_outbox_t *outbox) {
    if (access->operation == PARAMETER_SAVE) {
        begin_save(self, access, outbox);
        return;
    }
    const bool announced = access->parameter + 1u < self->announced;
    if (access->operation == PARAMETER_WRITE && access->parameter < PARAMETER_COUNT && !announced) {
        controller_announce_parameter(self, access->parameter, outbox);
    }
    controller_send_parameter(self, access->parameter, access->sequence, read_or_write(self, access), outbox);
}
