/* See replay_store.h. */
#include "replay_store.h"

#include "replay_inbox.h"

void replay_boot(replay_t *self, const arm_t *arm) {
    bool is_known[PARAMETER_COUNT] = {false};
    int known = 0;
    result_t result = RESULT_ACCEPTED;
    parameters_t parameters;
    parameters_set_defaults(&parameters);
    for (uint32_t i = self->cursor[FRAME_PARAMETER_VALUE]; i != REPLAY_NO_FRAME && known < PARAMETER_COUNT; i = self->next[i]) {
        if (!replay_has_right_crc(&self->log[i], FRAME_PARAMETER_VALUE)) {
            continue;
        }
        parameter_value_t told;
        parameter_value_unpack(&self->log[i], &told);
        if (told.sequence == 0u && told.parameter < PARAMETER_COUNT && !is_known[told.parameter]) {
            (void)parameters_set(&parameters, told.parameter, told.value);
            is_known[told.parameter] = true;
            result = told.result;
            known++;
        }
    }
    controller_init(&self->controller, arm);
    controller_set_parameters(&self->controller, &parameters, result);
}

bool replay_ends_save(replay_t *self) {
    uint32_t place = self->cursor[FRAME_PARAMETER_VALUE];
    if (!self->before.saving || place >= self->tick_place) {
        return false;
    }
    parameter_value_t answer; /* the first of the tick */
    parameter_value_unpack(&self->log[place], &answer);
    for (int i = 0; i < self->outbox.count && place != REPLAY_NO_FRAME; i++) {
        if (self->outbox.frame[i].id == frame_table[FRAME_PARAMETER_VALUE].id) {
            place = self->next[place];
        }
    }
    self->inbox.save_over = place < self->tick_place;
    self->inbox.save_result = answer.result;
    return self->inbox.save_over;
}
