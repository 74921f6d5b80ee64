/* The state machine of the modes: see supervisor.h. */
#include "supervisor.h"

static void enter(supervisor_t *self, control_mode_t mode, reason_t reason) {
    self->mode = mode;
    self->reason = reason;
}

void supervisor_init(supervisor_t *self) {
    enter(self, MODE_IDLE, REASON_BOOT);
}

/* Returns true, and sets *reason, if there is a cause for mode fault. */
static bool fault_present(const supervisor_inputs_t *inputs, reason_t *reason) {
    if (!inputs->finite) {
        *reason = REASON_NOT_FINITE;
        return true;
    }
    switch (inputs->joints.finding) {
    case JOINT_WATCH_SILENT: *reason = REASON_DRIVE_SILENT; return true;
    case JOINT_WATCH_ERROR: *reason = REASON_DRIVE_ERROR; return true;
    case JOINT_WATCH_OUT_OF_RANGE: *reason = REASON_JOINT_OUT_OF_RANGE; return true;
    case JOINT_WATCH_DEVIATES: *reason = REASON_JOINT_DEVIATES; return true;
    case JOINT_WATCH_WRONG_MODE: *reason = REASON_DRIVE_MODE; return true;
    default: return false;
    }
}

static void follow_readiness(supervisor_t *self, const supervisor_inputs_t *inputs) {
    if (inputs->joints.finding != JOINT_WATCH_OK) {
        enter(self, MODE_IDLE, REASON_WAITING_FOR_DRIVES);
    } else if (!inputs->tracker_fresh) {
        enter(self, MODE_IDLE, REASON_WAITING_FOR_TRACKER);
    } else if (self->mode == MODE_IDLE) {
        enter(self, MODE_READY, REASON_INPUTS_READY);
    }
}

void supervisor_update(supervisor_t *self, const supervisor_inputs_t *inputs) {
    if (self->mode == MODE_FAULT) {
        return;
    }
    reason_t cause;
    if ((supervisor_is_engaged(self) || inputs->powered) && fault_present(inputs, &cause)) {
        enter(self, MODE_FAULT, cause);
    } else if (!supervisor_is_engaged(self)) {
        follow_readiness(self, inputs);
    } else if (self->mode == MODE_COOPERATING && !inputs->tracker_fresh) {
        enter(self, MODE_HOLD, REASON_TRACKER_STALE);
    } else if (self->mode == MODE_HOLD && inputs->tracker_fresh) {
        enter(self, MODE_COOPERATING, REASON_TRACKER_RETURNED);
    }
}

result_t supervisor_start(supervisor_t *self, const supervisor_inputs_t *inputs) {
    if (self->mode != MODE_READY) {
        return RESULT_WRONG_MODE;
    }
    if (!inputs->joints.in_range) {
        return RESULT_JOINT_OUT_OF_RANGE;
    }
    if (!inputs->joints.at_rest) {
        return RESULT_NOT_AT_REST;
    }
    enter(self, MODE_COOPERATING, REASON_OPERATOR_START);
    return RESULT_ACCEPTED;
}

result_t supervisor_stop(supervisor_t *self) {
    if (self->mode == MODE_FAULT) {
        return RESULT_NOT_ACKNOWLEDGED;
    }
    if (supervisor_is_engaged(self)) {
        enter(self, MODE_READY, REASON_OPERATOR_STOP);
    }
    return RESULT_ACCEPTED;
}

result_t supervisor_acknowledge(supervisor_t *self, const supervisor_inputs_t *inputs) {
    if (supervisor_is_engaged(self)) {
        return RESULT_WRONG_MODE;
    }
    if (self->mode == MODE_FAULT) {
        reason_t cause;
        if (fault_present(inputs, &cause)) {
            return RESULT_FAULT_PRESENT;
        }
        if (inputs->powered || !inputs->joints.at_rest) {
            return RESULT_NOT_AT_REST;
        }
        enter(self, MODE_IDLE, REASON_FAULT_CLEARED);
    }
    return RESULT_ACCEPTED;
}

stop_category_t supervisor_stop_category(const supervisor_t *self) {
    switch (self->mode) {
    case MODE_HOLD: return STOP_CATEGORY_2;
    case MODE_FAULT: return STOP_CATEGORY_1;
    default: return STOP_NONE;
    }
}
