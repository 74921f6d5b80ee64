/* Indexes the frames of a log by id. A part of the replay. */
#ifndef COMANIP_REPLAY_LOG_H
#define COMANIP_REPLAY_LOG_H

#include "replay.h"

typedef struct {
    tick_trace_t message;
    e2e_receiver_t last[FRAME_KIND_COUNT]; /* by frame kind: counter of the last frame that the firmware had read */
} replay_trace_t;

/* Sets stream_of and next for all frames. */
void replay_log_index(replay_t *self);

/* Return a stream: by kind that of the message's first frame, by id that of the frame. */
replay_stream_t *replay_stream_of_kind(replay_t *self, frame_kind_t kind);
replay_stream_t *replay_stream_of_id(replay_t *self, uint16_t id);

uint8_t replay_counter_of(const replay_t *self, const can_frame_t *frame);

/* Returns the bits of a counter that are compared, as a mask. */
uint8_t replay_counter_mask(const replay_t *self);

/* Checks a frame and updates the receiver's counter as the firmware does. */
e2e_status_t replay_follow(const replay_t *self, const replay_stream_t *stream, e2e_receiver_t *receiver,
                           const can_frame_t *frame);
bool replay_has_right_crc(const replay_t *self, const replay_stream_t *stream, const can_frame_t *frame);

/* Returns the firmware's end-to-end receiver for this stream. */
e2e_receiver_t *replay_receiver(replay_t *self, const replay_stream_t *stream);

/* Reads a TickTrace. place: index in the log of the TickTrace or of its first part. part_place: receives the indices of
 * all parts in order. Returns false if a part is damaged or missing; part_place[0] is then the index of the damaged
 * part, or REPLAY_NO_FRAME. */
bool replay_read_trace(replay_t *self, uint32_t place, replay_trace_t *trace, uint32_t part_place[REPLAY_TRACE_PARTS]);

#endif
