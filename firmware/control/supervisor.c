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
    } else if (!inputs->drives_fresh) {
        *reason = REASON_DRIVE_SILENT;
    } else if (inputs->drive_error) {
        *reason = REASON_DRIVE_ERROR;
    } else {
        return false;
    }
    return true;
}

static void follow_readiness(supervisor_t *self, const supervisor_inputs_t *inputs) {
    if (!inputs->drives_fresh || inputs->drive_error) {
        enter(self, MODE_IDLE, REASON_WAITING_FOR_DRIVES);
    } else if (!inputs->tracker_fresh) {
        enter(self, MODE_IDLE, REASON_WAITING_FOR_TRACKER);
    } else if (self->mode == MODE_IDLE) {
        enter(self, MODE_READY, REASON_INPUTS_READY);
    }
}

void supervisor_update(supervisor_t *self, const supervisor_inputs_t *inputs) {
    reason_t cause;
    switch (self->mode) {
    case MODE_IDLE:
    case MODE_READY: follow_readiness(self, inputs); break;
    case MODE_COOPERATING:
    case MODE_HOLD:
        if (fault_present(inputs, &cause)) {
            enter(self, MODE_FAULT, cause);
        } else if (self->mode == MODE_COOPERATING && !inputs->tracker_fresh) {
            enter(self, MODE_HOLD, REASON_TRACKER_STALE);
        } else if (self->mode == MODE_HOLD && inputs->tracker_fresh) {
            enter(self, MODE_COOPERATING, REASON_TRACKER_RETURNED);
        }
        break;
    case MODE_FAULT: break;
    }
}

result_t supervisor_start(supervisor_t *self) {
    if (self->mode != MODE_READY) {
        return RESULT_WRONG_MODE;
    }
    enter(self, MODE_COOPERATING, REASON_OPERATOR_START);
    return RESULT_ACCEPTED;
}

result_t supervisor_stop(supervisor_t *self, const supervisor_inputs_t *inputs) {
    reason_t cause;
    switch (self->mode) {
    case MODE_COOPERATING:
    case MODE_HOLD: enter(self, MODE_READY, REASON_OPERATOR_STOP); break;
    case MODE_FAULT:
        if (fault_present(inputs, &cause)) {
            return RESULT_FAULT_PRESENT;
        }
        enter(self, MODE_IDLE, REASON_FAULT_CLEARED);
        break;
    case MODE_IDLE:
    case MODE_READY: break;
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
