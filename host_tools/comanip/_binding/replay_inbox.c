/* Reconstructs the inbox of a recorded tick: see replay_inbox.h. */
#include "replay_inbox.h"

#include <stddef.h>

#include "replay_log.h"

#define LOOK_AHEAD_TICKS 4 /* timeout of JointState in ticks, plus the tick itself */

/* Returns the largest step of an end-to-end counter that the firmware accepts. */
static uint8_t max_delta(const replay_t *self) {
    return self->profile == CAN_PROFILE_CLASSIC ? E2E_PROFILE2_MAX_DELTA : E2E_MAX_DELTA;
}

static bool add_to_inbox(replay_t *self, uint32_t place) {
    if (self->inbox.count == CONTROLLER_INBOX_FRAMES) {
        return false;
    }
    int i = self->inbox.count++;
    for (; i > 0 && self->place_of[i - 1] > place; i--) { /* insertion sort, into the order on the bus */
        self->place_of[i] = self->place_of[i - 1];
        self->inbox.frame[i] = self->inbox.frame[i - 1];
    }
    self->place_of[i] = place;
    self->inbox.frame[i] = self->log[place];
    return true;
}

/* Moves the cursor to the last frame with the traced counter among the frames before the tick. Earlier frames with this
 * id may have been sent before the firmware booted. */
static void skip_unheard(replay_t *self, replay_stream_t *stream, uint8_t counter) {
    for (uint32_t i = stream->cursor; i < self->tick_place; i = self->next[i]) {
        if (replay_counter_of(self, &self->log[i]) == counter && replay_has_right_crc(self, stream, &self->log[i])) {
            stream->cursor = i;
        }
    }
}

static bool is_read(const replay_t *self, replay_plan_t plan, const replay_stream_t *stream, uint8_t distance) {
    if (plan == REPLAY_READ_ALL || distance == 0u) {
        return true;
    }
    if (stream->kind == FRAME_HAND_POSE) {
        return plan < REPLAY_READ_NEWEST;
    }
    if (stream->description->period_ms == 0u) {
        return true; /* a request by the operator: the log contains the answer, so the firmware has read the request */
    }
    return plan == REPLAY_READ_BRIDGED_STATES && distance % (max_delta(self) - 2u) == 0u;
}

/* Adds the frames of one id to the inbox, up to the one with the traced counter. Returns false if there is no such
 * frame, or if there are more frames than a tick can read. */
static bool read_stream(replay_t *self, replay_stream_t *stream, const replay_trace_t *trace, replay_plan_t plan) {
    e2e_receiver_t receiver = *replay_receiver(self, stream);
    const uint8_t wanted = trace->last[stream->kind].counter;
    uint32_t damaged = REPLAY_NO_FRAME;
    if (!trace->last[stream->kind].started || (receiver.started && receiver.counter == wanted)) {
        return true;
    }
    if (!receiver.started) {
        skip_unheard(self, stream, wanted);
    }
    uint32_t place = stream->cursor;
    bool fits = true;
    for (int i = 0; i < replay_counter_mask(self) && place != REPLAY_NO_FRAME; i++, place = self->next[place]) {
        const can_frame_t *frame = &self->log[place];
        const bool crc_right = replay_follow(self, stream, &receiver, frame) != E2E_WRONG_CRC;
        if (!crc_right && damaged == REPLAY_NO_FRAME) {
            damaged = place;
        }
        if (is_read(self, plan, stream,
                    (uint8_t)(wanted - replay_counter_of(self, frame)) & replay_counter_mask(self))) {
            fits = add_to_inbox(self, place) && fits;
        }
        if (crc_right && receiver.counter == wanted) {
            stream->cursor = self->next[place];
            return fits;
        }
    }
    if (damaged != REPLAY_NO_FRAME) {
        replay_end(self, REPLAY_DAMAGED, damaged);
    } else {
        replay_note_lost(self, stream, wanted);
    }
    return false;
}

/* For joints that the arm lacks, no JointState is read, because no node sends one. */
bool replay_fill_inbox(replay_t *self, const replay_trace_t *trace, replay_plan_t plan) {
    self->inbox.count = 0;
    for (int i = 0; i < self->stream_count; i++) {
        if (self->to_firmware[self->stream[i].kind] && !read_stream(self, &self->stream[i], trace, plan)) {
            return false;
        }
    }
    return true;
}

/* Returns true if the firmware refuses this frame without recording its counter in the trace. */
static bool is_refused_unseen(replay_t *self, const replay_stream_t *stream, const can_frame_t *frame) {
    e2e_receiver_t receiver = *replay_receiver(self, stream);
    const e2e_status_t status = replay_follow(self, stream, &receiver, frame);
    const bool is_part =
        self->profile == CAN_PROFILE_CLASSIC && classic_parts(stream->kind, self->controller.arm->joint_count) > 1u;
    return status == E2E_WRONG_CRC || status == E2E_REPEATED ||
           (is_part && status == E2E_WRONG_SEQUENCE && stream->description->period_ms != 0u);
}

bool replay_read_refused(replay_t *self) {
    replay_stream_t *best = NULL;
    for (int i = 0; i < self->stream_count; i++) {
        replay_stream_t *stream = &self->stream[i];
        if (self->to_firmware[stream->kind] && stream->cursor < self->tick_place &&
            is_refused_unseen(self, stream, &self->log[stream->cursor]) &&
            (best == NULL || stream->cursor < best->cursor)) {
            best = stream;
        }
    }
    if (best == NULL || !add_to_inbox(self, best->cursor)) {
        return false;
    }
    best->cursor = self->next[best->cursor];
    return true;
}

/* ---- times of reception */

/* Considers the ticks from this one up to the drive's next frame. Returns the oldest timestamp with which the drive
 * counts as fresh in all of these ticks whose trace reports fresh drives. */
static uint32_t joint_stamp_us(replay_t *self, frame_kind_t kind, const replay_trace_t *trace) {
    const uint32_t timeout_us = 1000u * transport_timeout_ms(self->profile, kind);
    uint32_t stamp_us = trace->message.now_us - timeout_us - 1u;
    uint8_t counter = trace->last[kind].counter;
    uint32_t place = self->tick_place;
    for (int i = 0; i < LOOK_AHEAD_TICKS && place != REPLAY_NO_FRAME; i++, place = self->next[place]) {
        replay_trace_t ahead;
        uint32_t part_place[REPLAY_TRACE_PARTS];
        if (!replay_read_trace(self, place, &ahead, part_place)) {
            break;
        }
        const uint8_t delta = (uint8_t)(ahead.last[kind].counter - counter) & replay_counter_mask(self);
        if (delta >= 1u && delta <= max_delta(self)) {
            break;
        }
        counter = ahead.last[kind].counter;
        if (ahead.message.drives_fresh) {
            stamp_us = ahead.message.now_us - timeout_us;
        }
    }
    return (int32_t)(trace->message.now_us - stamp_us) < 0 ? trace->message.now_us : stamp_us;
}

static uint32_t pose_stamp_us(const replay_t *self, const replay_trace_t *trace) {
    const uint32_t now_us = trace->message.now_us;
    if (trace->message.hand_age_us < TRACE_AGE_MAX_US) {
        return now_us - trace->message.hand_age_us;
    }
    return self->profile == CAN_PROFILE_CLASSIC ? self->before.receiver.pose_received_us + (now_us - self->pose_tick_us)
                                                : now_us;
}

void replay_stamp_inbox(replay_t *self, const replay_trace_t *trace) {
    for (int i = 0; i < self->inbox.count; i++) {
        const frame_kind_t kind = self->stream[self->stream_of[self->place_of[i]]].kind;
        uint32_t stamp_us = trace->message.now_us;
        if (kind == FRAME_HAND_POSE) {
            stamp_us = pose_stamp_us(self, trace);
        } else if (kind >= FRAME_JOINT_STATE0 && kind <= FRAME_JOINT_STATE7) {
            stamp_us = joint_stamp_us(self, kind, trace);
        }
        self->inbox.frame[i].timestamp_us = stamp_us;
    }
}
