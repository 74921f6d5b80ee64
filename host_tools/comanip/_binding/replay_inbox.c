/* See replay_inbox.h. */
#include "replay_inbox.h"

#define LOOK_AHEAD_TICKS 4 /* JointState's timeout, in ticks, and the tick itself */
#define BRIDGE 8           /* frames of one id, below E2E_MAX_DELTA */

/* Follows the receiver's counter, as the firmware does. False: the frame leaves no mark on it. */
static bool follow(e2e_receiver_t *receiver, const can_frame_t *frame, frame_kind_t kind, bool *crc_right) {
    *crc_right = false;
    if (frame->length != frame_table[kind].length) {
        return false;
    }
    e2e_status_t status = e2e_check(receiver, frame->data, frame->length, frame_table[kind].data_id);
    *crc_right = status != E2E_WRONG_CRC;
    return *crc_right && status != E2E_REPEATED;
}

bool replay_has_right_crc(const can_frame_t *frame, frame_kind_t kind) {
    e2e_receiver_t receiver = {0};
    bool crc_right;
    (void)follow(&receiver, frame, kind, &crc_right);
    return crc_right;
}

static bool add_to_inbox(replay_t *self, uint32_t place) {
    if (self->inbox.count == CONTROLLER_INBOX_FRAMES) {
        return false;
    }
    int i = self->inbox.count++;
    for (; i > 0 && self->place_of[i - 1] > place; i--) { /* in the order of the bus */
        self->place_of[i] = self->place_of[i - 1];
        self->inbox.frame[i] = self->inbox.frame[i - 1];
    }
    self->place_of[i] = place;
    self->inbox.frame[i] = self->log[place];
    return true;
}

/* A firmware that has just booted had not heard what came before: only the last frame before the tick is sure. */
static void skip_unheard(replay_t *self, frame_kind_t kind, uint8_t counter) {
    for (uint32_t i = self->cursor[kind]; i < self->tick_place; i = self->next[i]) {
        if (self->log[i].data[2] == counter && replay_has_right_crc(&self->log[i], kind)) {
            self->cursor[kind] = i;
        }
    }
}

static bool is_read(replay_plan_t plan, frame_kind_t kind, uint8_t distance) {
    if (plan == REPLAY_READ_ALL || distance == 0u) {
        return true;
    }
    if (kind == FRAME_HAND_POSE) {
        return plan < REPLAY_READ_NEWEST;
    }
    if (frame_table[kind].period_ms == 0u) {
        return true; /* an operator's frame: its answer is in the log */
    }
    return plan == REPLAY_READ_BRIDGED_STATES && distance % BRIDGE == 0u;
}

/* Takes the frames of one id up to the one with the traced counter. False: there is none, or more than a tick reads. */
static bool read_kind(replay_t *self, frame_kind_t kind, const tick_trace_t *trace, replay_plan_t plan) {
    e2e_receiver_t receiver = self->controller.receiver.e2e[kind];
    const uint8_t wanted = trace->last_counter[kind];
    uint32_t damaged = REPLAY_NO_FRAME;
    if (!trace->received[kind] || (receiver.started && receiver.counter == wanted)) {
        return true;
    }
    if (!receiver.started) {
        skip_unheard(self, kind, wanted);
    }
    uint32_t place = self->cursor[kind];
    bool fits = true;
    for (int i = 0; i < UINT8_MAX && place != REPLAY_NO_FRAME; i++, place = self->next[place]) {
        bool crc_right;
        (void)follow(&receiver, &self->log[place], kind, &crc_right);
        if (!crc_right && damaged == REPLAY_NO_FRAME) {
            damaged = place;
        }
        if (is_read(plan, kind, (uint8_t)(wanted - self->log[place].data[2]))) {
            fits = add_to_inbox(self, place) && fits;
        }
        if (crc_right && receiver.counter == wanted) {
            self->cursor[kind] = self->next[place];
            return fits;
        }
    }
    if (damaged != REPLAY_NO_FRAME) {
        replay_end(self, REPLAY_DAMAGED, damaged);
    } else {
        replay_note_lost(self, kind, wanted);
    }
    return false;
}

bool replay_fill_inbox(replay_t *self, const tick_trace_t *trace, replay_plan_t plan) {
    self->inbox.count = 0;
    for (int kind = 0; kind < FRAME_KIND_COUNT; kind++) {
        if (self->to_firmware[kind] && !read_kind(self, (frame_kind_t)kind, trace, plan)) {
            return false;
        }
    }
    return true;
}

bool replay_read_refused(replay_t *self) {
    int best = FRAME_KIND_COUNT;
    for (int kind = 0; kind < FRAME_KIND_COUNT; kind++) {
        const uint32_t place = self->cursor[kind];
        if (!self->to_firmware[kind] || place >= self->tick_place) {
            continue;
        }
        e2e_receiver_t receiver = self->controller.receiver.e2e[kind];
        bool crc_right;
        bool leaves_a_mark = follow(&receiver, &self->log[place], (frame_kind_t)kind, &crc_right);
        if (!leaves_a_mark && (best == FRAME_KIND_COUNT || place < self->cursor[best])) {
            best = kind;
        }
    }
    if (best == FRAME_KIND_COUNT || !add_to_inbox(self, self->cursor[best])) {
        return false;
    }
    self->cursor[best] = self->next[self->cursor[best]];
    return true;
}

/* ---- times of reception */

/* The oldest stamp with which the drive stays fresh in the ticks that say so, until its next frame. */
static uint32_t joint_stamp_us(const replay_t *self, frame_kind_t kind, const tick_trace_t *trace) {
    const uint32_t timeout_us = 1000u * frame_table[kind].timeout_ms;
    uint32_t stamp_us = trace->now_us - timeout_us - 1u;
    uint8_t counter = trace->last_counter[kind];
    uint32_t place = self->tick_place;
    for (int i = 0; i < LOOK_AHEAD_TICKS && place != REPLAY_NO_FRAME; i++, place = self->next[place]) {
        tick_trace_t ahead;
        tick_trace_unpack(&self->log[place], &ahead);
        const uint8_t delta = (uint8_t)(ahead.last_counter[kind] - counter);
        if (delta >= 1u && delta <= E2E_MAX_DELTA) {
            break;
        }
        counter = ahead.last_counter[kind];
        if (ahead.drives_fresh) {
            stamp_us = ahead.now_us - timeout_us;
        }
    }
    return (int32_t)(trace->now_us - stamp_us) < 0 ? trace->now_us : stamp_us;
}

void replay_stamp_inbox(replay_t *self, const tick_trace_t *trace) {
    for (int i = 0; i < self->inbox.count; i++) {
        const frame_kind_t kind = (frame_kind_t)self->kind[self->place_of[i]];
        uint32_t stamp_us = trace->now_us;
        if (kind == FRAME_HAND_POSE) {
            stamp_us -= trace->hand_age_us;
        } else if (kind >= FRAME_JOINT_STATE0 && kind <= FRAME_JOINT_STATE7) {
            stamp_us = joint_stamp_us(self, kind, trace);
        }
        self->inbox.frame[i].timestamp_us = stamp_us;
    }
}
