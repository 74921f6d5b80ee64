/* Indexes the frames of a log: see replay_log.h. */
#include "replay_log.h"

#include <string.h>

#define TRACE_WITHIN_FRAMES 400 /* maximum distance in frames between the parts of a TickTrace */

static void add_stream(replay_t *self, const frame_description_t *description, frame_kind_t kind) {
    self->stream[self->stream_count++] =
        (replay_stream_t){.description = description, .kind = kind, .cursor = REPLAY_NO_FRAME};
}

static void list_streams(replay_t *self) {
    if (self->profile == CAN_PROFILE_FD) {
        for (int kind = 0; kind < FRAME_KIND_COUNT; kind++) {
            add_stream(self, &frame_table[kind], (frame_kind_t)kind);
        }
        return;
    }
    for (int i = 0; i < CLASSIC_FRAME_COUNT; i++) {
        classic_frame_t frame;
        frame_kind_t kind;
        (void)classic_find(classic_table[i].id, &frame, &kind);
        add_stream(self, &classic_table[i], kind);
    }
    for (int kind = 0; kind < FRAME_KIND_COUNT; kind++) {
        if (transport_is_same_frame((frame_kind_t)kind)) {
            add_stream(self, &frame_table[kind], (frame_kind_t)kind);
        }
    }
}

replay_stream_t *replay_stream_of_id(replay_t *self, uint16_t id) {
    for (int i = 0; i < self->stream_count; i++) {
        if (self->stream[i].description->id == id) {
            return &self->stream[i];
        }
    }
    return NULL;
}

replay_stream_t *replay_stream_of_kind(replay_t *self, frame_kind_t kind) {
    return replay_stream_of_id(self, transport_first_id(self->profile, kind));
}

void replay_log_index(replay_t *self) {
    list_streams(self);
    for (uint32_t i = self->count; i-- > 0;) {
        replay_stream_t *stream = replay_stream_of_id(self, self->log[i].id);
        self->stream_of[i] = REPLAY_NO_STREAM;
        if (stream != NULL) {
            self->stream_of[i] = (uint8_t)(stream - self->stream);
            self->next[i] = stream->cursor;
            stream->cursor = i;
        }
    }
}

/* ---- end-to-end protection */

uint8_t replay_counter_mask(const replay_t *self) {
    return self->profile == CAN_PROFILE_CLASSIC ? E2E_PROFILE2_COUNTERS - 1u : UINT8_MAX;
}

uint8_t replay_counter_of(const replay_t *self, const can_frame_t *frame) {
    return self->profile == CAN_PROFILE_CLASSIC ? frame->data[1] & replay_counter_mask(self) : frame->data[2];
}

e2e_status_t replay_follow(const replay_t *self, const replay_stream_t *stream, e2e_receiver_t *receiver,
                           const can_frame_t *frame) {
    const frame_description_t *description = stream->description;
    if (frame->length != description->length) {
        return E2E_WRONG_CRC;
    }
    return self->profile == CAN_PROFILE_CLASSIC
               ? e2e_profile2_check(receiver, frame->data, frame->length, description->data_id)
               : e2e_check(receiver, frame->data, frame->length, description->data_id);
}

bool replay_has_right_crc(const replay_t *self, const replay_stream_t *stream, const can_frame_t *frame) {
    e2e_receiver_t receiver = {0};
    return replay_follow(self, stream, &receiver, frame) != E2E_WRONG_CRC;
}

e2e_receiver_t *replay_receiver(replay_t *self, const replay_stream_t *stream) {
    return self->profile == CAN_PROFILE_CLASSIC ? &self->controller.receiver.classic[stream - self->stream]
                                                : &self->controller.receiver.protocol.e2e[stream->kind];
}

/* ---- the trace */

/* Returns the index of the first frame of the stream with this counter, at or after `place`, or REPLAY_NO_FRAME. */
static uint32_t find_part(const replay_t *self, const replay_stream_t *stream, uint32_t place, uint8_t counter) {
    const uint32_t limit = self->count - place < TRACE_WITHIN_FRAMES ? self->count : place + TRACE_WITHIN_FRAMES;
    const uint8_t number = (uint8_t)(stream - self->stream);
    for (uint32_t i = place; i < limit; i++) {
        if (self->stream_of[i] == number && replay_counter_of(self, &self->log[i]) == counter) {
            return i;
        }
    }
    return REPLAY_NO_FRAME;
}

bool replay_read_trace(replay_t *self, uint32_t place, replay_trace_t *trace, uint32_t part_place[REPLAY_TRACE_PARTS]) {
    const replay_stream_t *first = &self->stream[self->stream_of[place]];
    const uint8_t parts =
        self->profile == CAN_PROFILE_CLASSIC ? classic_parts(FRAME_TICK_TRACE, self->controller.arm->joint_count) : 1u;
    uint8_t part[CLASSIC_MAX_PARTS][CLASSIC_MAX_BYTES];
    for (uint8_t i = 0; i < parts; i++) {
        const uint32_t found = find_part(self, first + i, place, replay_counter_of(self, &self->log[place]));
        if (found == REPLAY_NO_FRAME || !replay_has_right_crc(self, first + i, &self->log[found])) {
            part_place[0] = found;
            return false;
        }
        part_place[i] = found;
        memcpy(part[i], self->log[found].data, CLASSIC_MAX_BYTES);
    }
    can_frame_t message = self->log[place];
    if (self->profile == CAN_PROFILE_CLASSIC) {
        classic_join(FRAME_TICK_TRACE, part, message.data);
    }
    tick_trace_unpack(&message, &trace->message);
    protocol_traced_inputs(&trace->message, trace->last);
    return true;
}
