/* Replays the ticks of a log and compares the frames: see replay.h. */
#include "replay.h"

#include <string.h>

#include "../../../firmware/maths/float_bits.h"
#include "comanip_identity.h"
#include "replay_inbox.h"
#include "replay_log.h"
#include "replay_store.h"

uint64_t replay_build_hash(void) {
    return COMANIP_BUILD_HASH;
}

uint32_t replay_trace_hash(void) {
    return COMANIP_TRACE_HASH;
}

uint8_t replay_trace_version(void) {
    return COMANIP_TRACE_VERSION;
}

void replay_init(replay_t *self, const arm_ik_t *ik, can_profile_t profile, const can_frame_t log[], uint32_t count,
                 uint8_t stream_of[], uint32_t next[], const bool to_firmware[], const bool from_firmware[]) {
    memset(self, 0, sizeof *self);
    self->log = log;
    self->count = count;
    self->stream_of = stream_of;
    self->next = next;
    self->profile = profile;
    memcpy(self->to_firmware, to_firmware, sizeof self->to_firmware);
    memcpy(self->from_firmware, from_firmware, sizeof self->from_firmware);
    replay_log_index(self);
    self->tick_place = replay_stream_of_kind(self, FRAME_TICK_TRACE)->cursor;
    self->boots = 1;
    replay_boot(self, ik);
}

void replay_leave_out(replay_t *self, const bool left_out[FRAME_KIND_COUNT]) {
    memcpy(self->left_out, left_out, sizeof self->left_out);
}

void replay_other_build(replay_t *self, const bool has_parameter[PARAMETER_NUMBERS]) {
    self->is_of_another_build = true;
    memcpy(self->has_parameter, has_parameter, sizeof self->has_parameter);
}

/* ---- differences */

void replay_end(replay_t *self, replay_result_t result, uint32_t place) {
    if (self->result == REPLAY_EQUAL || place < self->place) {
        self->result = result;
        self->place = place;
    }
}

void replay_note_lost(replay_t *self, const replay_stream_t *stream, uint8_t counter) {
    self->sent = (can_frame_t){.id = stream->description->id, .length = 1, .data = {counter}};
    replay_end(self, REPLAY_LOST, self->tick_place);
}

/* ---- comparison of frames */

/* Returns true for a ParameterValue whose parameter is missing from this build or from the build that recorded the
 * log. */
static bool is_of_one_build(const replay_t *self, const replay_stream_t *stream, const can_frame_t *frame) {
    if (!self->is_of_another_build || stream->kind != FRAME_PARAMETER_VALUE) {
        return false;
    }
    const uint8_t parameter = replay_parameter_value(self, frame).parameter;
    return !parameters_has(parameter) || parameter >= PARAMETER_NUMBERS || !self->has_parameter[parameter];
}

/* Skips recorded ParameterValues of parameters that only one of the two builds has. */
static void skip_recorded(replay_t *self, replay_stream_t *stream) {
    while (stream->cursor != REPLAY_NO_FRAME && is_of_one_build(self, stream, &self->log[stream->cursor])) {
        stream->cursor = self->next[stream->cursor];
    }
}

static bool is_equal(const replay_t *self, const replay_stream_t *stream, const can_frame_t *recorded,
                     const can_frame_t *sent) {
    if (recorded->length != sent->length) {
        return false;
    }
    if (self->is_of_another_build && stream->kind == FRAME_PARAMETER_VALUE) {
        const parameter_value_t a = replay_parameter_value(self, recorded), b = replay_parameter_value(self, sent);
        return a.parameter == b.parameter && a.sequence == b.sequence && a.result == b.result &&
               float_bits(a.value) == float_bits(b.value);
    }
    return memcmp(recorded->data, sent->data, sent->length) == 0;
}

static void compare_frame(replay_t *self, const can_frame_t *sent) {
    replay_stream_t *stream = replay_stream_of_id(self, sent->id);
    if (is_of_one_build(self, stream, sent)) {
        return;
    }
    if (self->left_out[stream->kind]) {
        stream->cursor = stream->cursor != REPLAY_NO_FRAME ? self->next[stream->cursor] : REPLAY_NO_FRAME;
        return;
    }
    skip_recorded(self, stream);
    const uint32_t place = stream->cursor;
    if (place == REPLAY_NO_FRAME) {
        if (self->next[self->tick_place] != REPLAY_NO_FRAME &&
            self->result == REPLAY_EQUAL) { /* the last tick is not checked: the log may end within it */
            self->sent = *sent;
            replay_end(self, REPLAY_NOT_IN_LOG, self->tick_place);
        }
        return;
    }
    if (!is_equal(self, stream, &self->log[place], sent)) {
        if (self->result == REPLAY_EQUAL || place < self->place) {
            self->sent = *sent;
        }
        replay_end(self, REPLAY_DIFFERENT, place);
    }
    stream->cursor = self->next[place];
    self->compared++;
}

/* Reports frames of the firmware that the log contains before index `limit` but that the replay has not sent. */
static void find_unsent(replay_t *self, uint32_t limit) {
    for (int i = 0; i < self->stream_count; i++) {
        replay_stream_t *stream = &self->stream[i];
        skip_recorded(self, stream);
        if (self->from_firmware[stream->kind] && !self->left_out[stream->kind] && stream->cursor < limit) {
            replay_end(self, REPLAY_NOT_SENT, stream->cursor);
        }
    }
}

/* ---- a tick */

/* Returns true if the firmware has rebooted before this tick. After a reboot its counters restart at 0, and it sends
 * its identity again. */
static bool is_reboot(replay_t *self) {
    const uint32_t heartbeat = replay_stream_of_kind(self, FRAME_FIRMWARE_HEARTBEAT)->cursor;
    return self->ticks > 0u && replay_counter_of(self, &self->log[self->tick_place]) == 0u &&
           heartbeat != REPLAY_NO_FRAME && self->log[heartbeat].data[0] == HEARTBEAT_BOOT_UP &&
           replay_stream_of_kind(self, FRAME_FIRMWARE_IDENTITY)->cursor < self->next[self->tick_place];
}

static void step(replay_t *self, const replay_trace_t *trace) {
    self->controller = self->before;
    replay_stamp_inbox(self, trace);
    self->inbox.save_over = false;
    self->received = self->inbox; /* a copy, because the step reassembles messages in place */
    outbox_step(&self->outbox, &self->controller, trace->message.now_us, &self->received);
    if (replay_ends_save(self)) {
        self->controller = self->before;
        self->received = self->inbox;
        outbox_step(&self->outbox, &self->controller, trace->message.now_us, &self->received);
    }
}

/* Returns true if the replayed firmware has sent exactly the TickTrace made of these parts. */
static bool has_sent(replay_t *self, const uint32_t part_place[]) {
    const uint16_t first_id = self->log[part_place[0]].id;
    for (int i = 0; i < self->outbox.count; i++) {
        const can_frame_t *sent = &self->outbox.frame[i];
        if (replay_stream_of_id(self, sent->id)->kind != FRAME_TICK_TRACE) {
            continue;
        }
        const can_frame_t *recorded = &self->log[part_place[sent->id - first_id]];
        if (sent->length != recorded->length || memcmp(sent->data, recorded->data, sent->length) != 0) {
            return false;
        }
    }
    return true;
}

/* Replays the tick under one assumption about the frames that it read. Returns false if the log contradicts the
 * assumption. */
static bool try_plan(replay_t *self, const replay_trace_t *trace, replay_plan_t plan) {
    self->controller = self->before;
    memcpy(self->stream, self->stream_before, sizeof self->stream);
    if (!replay_fill_inbox(self, trace, plan)) {
        return false;
    }
    step(self, trace);
    while ((uint8_t)self->controller.receiver.protocol.rejected != trace->message.rejected_frames &&
           replay_read_refused(self)) {
        step(self, trace);
    }
    return true;
}

/* Replays the tick under the first assumption that reproduces its TickTrace. If no assumption does, replays the tick
 * under the first assumption that the log does not contradict. Returns false if the log contradicts all assumptions. */
static bool redo_tick(replay_t *self, const uint32_t part_place[], const replay_trace_t *trace) {
    int first_possible = REPLAY_READ_PLANS;
    for (int plan = REPLAY_READ_ALL; plan < REPLAY_READ_PLANS && self->result == REPLAY_EQUAL; plan++) {
        if (try_plan(self, trace, (replay_plan_t)plan)) {
            if (has_sent(self, part_place)) {
                return true;
            }
            first_possible = first_possible == REPLAY_READ_PLANS ? plan : first_possible;
        }
    }
    return first_possible != REPLAY_READ_PLANS && try_plan(self, trace, (replay_plan_t)first_possible);
}

/* Ends the replay at a TickTrace that cannot be read. damaged: index of the damaged part, or REPLAY_NO_FRAME if a part
 * is missing, for example at the end of the log. */
static void end_without_trace(replay_t *self, uint32_t damaged) {
    if (damaged != REPLAY_NO_FRAME) {
        replay_end(self, REPLAY_DAMAGED, damaged);
    } else if (self->next[self->tick_place] != REPLAY_NO_FRAME) {
        replay_end(self, REPLAY_NOT_SENT, self->tick_place);
    } else {
        self->tick_place = REPLAY_NO_FRAME;
    }
}

/* Remembers that this tick read a valid HandPose. Call after the step, which reassembles the messages. */
static void note_pose(replay_t *self, uint32_t now_us) {
    for (int i = 0; i < self->received.count; i++) {
        const can_frame_t *frame = &self->received.frame[i];
        if (frame->id == frame_table[FRAME_HAND_POSE].id &&
            (frame->data[COMANIP_HAND_POSE_VALID_BYTE] & COMANIP_HAND_POSE_VALID_MASK) != 0u) {
            self->pose_tick_us = now_us;
        }
    }
}

static void replay_tick(replay_t *self) {
    replay_trace_t trace;
    uint32_t part_place[REPLAY_TRACE_PARTS];
    if (!replay_read_trace(self, self->tick_place, &trace, part_place)) {
        end_without_trace(self, part_place[0]);
        return;
    }
    if (is_reboot(self)) {
        find_unsent(self, self->former_tick_place);
        replay_boot(self, self->controller.ik);
        self->boots++;
    }
    self->before = self->controller;
    memcpy(self->stream_before, self->stream, sizeof self->stream);
    if (!redo_tick(self, part_place, &trace)) {
        if (self->result == REPLAY_EQUAL) {
            replay_note_lost(self, replay_stream_of_kind(self, FRAME_OPERATOR_COMMAND),
                             trace.last[FRAME_OPERATOR_COMMAND].counter);
        }
        return;
    }
    note_pose(self, trace.message.now_us);
    for (int i = 0; i < self->outbox.count; i++) {
        compare_frame(self, &self->outbox.frame[i]);
    }
    find_unsent(self, self->former_tick_place); /* excludes this tick, whose frames may come in another order */
    self->fed += self->inbox.count;
    self->ticks++;
    self->former_tick_place = self->tick_place;
    self->tick_place = self->next[self->tick_place];
}

bool replay_run(replay_t *self, uint32_t end_place) {
    while (self->result == REPLAY_EQUAL && self->tick_place < end_place) {
        replay_tick(self);
    }
    return self->result == REPLAY_EQUAL && self->tick_place != REPLAY_NO_FRAME;
}

void replay_finish(replay_t *self) {
    if (self->result != REPLAY_EQUAL) {
        return;
    }
    const uint32_t command = replay_stream_of_kind(self, FRAME_JOINT_CMD)->cursor;
    const bool within_tick = command == REPLAY_NO_FRAME || self->next[command] == REPLAY_NO_FRAME;
    find_unsent(self, within_tick ? self->former_tick_place : REPLAY_NO_FRAME);
}
