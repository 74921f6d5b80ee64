/* The part of the replay that indexes the frames of a log by id and reads TickTraces. */
#ifndef COMANIP_REPLAY_LOG_H
#define COMANIP_REPLAY_LOG_H

#include "replay.h"

typedef struct {
    tick_trace_t message;
    e2e_receiver_t last[FRAME_KIND_COUNT]; /* by frame kind: counter of the last frame that the firmware had read */
} replay_trace_t;

/* Lists the streams, and sets stream_of and next for the frames of the log. */
void replay_log_index(replay_t *self);

/* Returns the stream of a message. If the message consists of several frames, the stream is that of the first frame. */
replay_stream_t *replay_stream_of_kind(replay_t *self, frame_kind_t kind);

/* Returns the stream of the frames with this id, or NULL if the profile has no such id. */
replay_stream_t *replay_stream_of_id(replay_t *self, uint16_t id);

uint8_t replay_counter_of(const replay_t *self, const can_frame_t *frame);

/* Returns the largest value of a counter, which is also the mask for differences of counters. */
uint8_t replay_counter_mask(const replay_t *self);

/* Checks a frame and updates the receiver's counter as the firmware does. */
e2e_status_t replay_follow(const replay_t *self, const replay_stream_t *stream, e2e_receiver_t *receiver,
                           const can_frame_t *frame);
bool replay_has_right_crc(const replay_t *self, const replay_stream_t *stream, const can_frame_t *frame);

/* Returns the firmware's end-to-end receiver for this stream. */
e2e_receiver_t *replay_receiver(replay_t *self, const replay_stream_t *stream);

/* Reads the TickTrace whose first frame is at index `place` of the log. A TickTrace is one frame on CAN FD and several
 * on classic CAN. Stores the indices of these frames in part_place. If a frame is damaged or missing, returns false
 * and sets part_place[0] to the index of the damaged frame, or to REPLAY_NO_FRAME if the frame is missing. */
bool replay_read_trace(replay_t *self, uint32_t place, replay_trace_t *trace, uint32_t part_place[REPLAY_TRACE_PARTS]);

#endif
