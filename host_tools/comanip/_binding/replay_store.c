/* Reconstructs the stored parameters of the recorded firmware: see replay_store.h. */
#include "replay_store.h"

#include <string.h>

#include "replay_log.h"

parameter_value_t replay_parameter_value(const replay_t *self, const can_frame_t *frame) {
    can_frame_t message = *frame;
    if (self->profile == CAN_PROFILE_CLASSIC) {
        uint8_t part[CLASSIC_MAX_PARTS][CLASSIC_MAX_BYTES] = {{0}};
        memcpy(part[0], frame->data, CLASSIC_MAX_BYTES);
        classic_join(FRAME_PARAMETER_VALUE, part, message.data);
    }
    parameter_value_t value;
    parameter_value_unpack(&message, &value);
    return value;
}

void replay_boot(replay_t *self, const arm_ik_t *ik) {
    const replay_stream_t *stream = replay_stream_of_kind(self, FRAME_PARAMETER_VALUE);
    bool is_known[PARAMETER_COUNT] = {false};
    int known = 0;
    result_t result = RESULT_ACCEPTED;
    parameters_t parameters;
    parameters_set_defaults(&parameters);
    for (uint32_t i = stream->cursor; i != REPLAY_NO_FRAME && known < PARAMETER_COUNT; i = self->next[i]) {
        const parameter_value_t told = replay_parameter_value(self, &self->log[i]);
        if (replay_has_right_crc(self, stream, &self->log[i]) && told.sequence == 0u &&
            told.parameter < PARAMETER_COUNT && !is_known[told.parameter]) {
            (void)parameters_set(&parameters, told.parameter, told.value);
            is_known[told.parameter] = true;
            result = told.result == RESULT_PARAMETERS_UNSTABLE ? result
                                                               : told.result; /* UNSTABLE does not concern the store */
            known++;
        }
    }
    controller_init(&self->controller, ik, self->profile);
    controller_set_parameters(&self->controller, &parameters, result);
}

/* Returns true for an answer to the pending save, or to another request with the same parameter and sequence number. */
static bool is_answer(const replay_t *self, const can_frame_t *frame) {
    const parameter_value_t value = replay_parameter_value(self, frame);
    return value.parameter == self->before.save_parameter && value.sequence == self->before.save_sequence;
}

bool replay_ends_save(replay_t *self) {
    if (!self->before.saving) {
        return false;
    }
    const replay_stream_t *stream = replay_stream_of_kind(self, FRAME_PARAMETER_VALUE);
    int surplus = 0;
    for (uint32_t i = stream->cursor; i < self->tick_place; i = self->next[i]) {
        if (is_answer(self, &self->log[i])) {
            self->inbox.save_result =
                surplus == 0 ? replay_parameter_value(self, &self->log[i]).result : self->inbox.save_result;
            surplus++;
        }
    }
    for (int i = 0; i < self->outbox.count; i++) {
        surplus -= self->outbox.frame[i].id == stream->description->id && is_answer(self, &self->outbox.frame[i]);
    }
    self->inbox.save_over = surplus > 0; /* the log has an answer that the replay has not sent */
    return self->inbox.save_over;
}
