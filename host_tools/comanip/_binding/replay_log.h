/* The frames of a recorded bus, by their ids; a part of the replay. */
#ifndef COMANIP_REPLAY_LOG_H
#define COMANIP_REPLAY_LOG_H

#include "replay.h"

typedef struct {
    tick_trace_t message;
    e2e_receiver_t last[FRAME_KIND_COUNT]; /* that the tick had read, by frame kind */
} replay_trace_t;

/* Finds out which frame is of which stream. */
void replay_log_index(replay_t *self);

/* Of the message's only frame, or its first part. */
replay_stream_t *replay_stream_of_kind(replay_t *self, frame_kind_t kind);
replay_stream_t *replay_stream_of_id(replay_t *self, uint16_t id);

uint8_t replay_counter_of(const replay_t *self, const can_frame_t *frame);

/* Counters are equal modulo this mask, plus 1. */
uint8_t replay_counter_mask(const replay_t *self);

/* Follows the counter, as the firmware does. */
e2e_status_t replay_follow(const replay_t *self, const replay_stream_t *stream, e2e_receiver_t *receiver,
                           const can_frame_t *frame);
bool replay_has_right_crc(const replay_t *self, const replay_stream_t *stream, const can_frame_t *frame);

/* The firmware's own, for this stream. */
e2e_receiver_t *replay_receiver(replay_t *self, const replay_stream_t *stream);

/* place: of a TickTrace, or of its first part; part_place: of all of them, in their order. False: *part_place[0] is
 * that of a damaged one, or REPLAY_NO_FRAME if one is missing. */
bool replay_read_trace(replay_t *self, uint32_t place, replay_trace_t *trace, uint32_t part_place[REPLAY_TRACE_PARTS]);

#endif
