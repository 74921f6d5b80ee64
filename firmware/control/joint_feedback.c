/* The reported state of the joints: see joint_feedback.h. */
#include "joint_feedback.h"

void joint_feedback_init(joint_feedback_t *self, uint32_t timeout_us) {
    *self = (joint_feedback_t){.timeout_us = timeout_us};
}

void joint_feedback_receive(joint_feedback_t *self, int joint, const joint_state_t *state, uint32_t received_us) {
    self->position_rad[joint] = state->position_rad;
    self->error[joint] = state->error;
    self->received_us[joint] = received_us;
    self->received[joint] = true;
}

bool joint_feedback_check_fresh(joint_feedback_t *self, int joint_count, uint32_t now_us) {
    bool fresh = true;
    for (int i = 0; i < joint_count; i++) {
        if (now_us - self->received_us[i] > self->timeout_us) {
            self->received[i] = false;
        }
        fresh = fresh && self->received[i];
    }
    return fresh;
}

bool joint_feedback_has_error(const joint_feedback_t *self, int joint_count) {
    for (int i = 0; i < joint_count; i++) {
        if (self->error[i] != DRIVE_ERROR_NONE) {
            return true;
        }
    }
    return false;
}
