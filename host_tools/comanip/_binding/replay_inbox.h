/* The part of the replay that reconstructs, from a TickTrace, which frames the recorded firmware read in that tick. */
#ifndef COMANIP_REPLAY_INBOX_H
#define COMANIP_REPLAY_INBOX_H

#include "replay_log.h"

/* Assumptions about the frames that a tick read. If the firmware's receive queue overflowed, for example after a pause,
 * the log does not show which frames were lost. The replay tries the assumptions in this order until the replayed tick
 * sends the recorded TickTrace. */
typedef enum {
    REPLAY_READ_ALL,            /* all frames up to the traced counter */
    REPLAY_READ_BRIDGED_STATES, /* of the drives' states, only those without which the counter check would fail */
    REPLAY_READ_NEWEST_STATES,  /* of the drives' states, only the newest of each drive */
    REPLAY_READ_NEWEST, /* of the drives' states, only the newest of each drive, and only the newest pose of the hand */
    REPLAY_READ_PLANS
} replay_plan_t;

/* Records a difference at index `place`, unless a difference at an earlier index is already recorded. */
void replay_end(replay_t *self, replay_result_t result, uint32_t place);

/* Records REPLAY_LOST for the frame of this stream with this counter. */
void replay_note_lost(replay_t *self, const replay_stream_t *stream, uint8_t counter);

/* Fills the inbox with the frames up to the traced counters. If a frame with a traced counter is damaged or not in the
 * log, records a difference and returns false. Also returns false if there are more frames than a tick can read. */
bool replay_fill_inbox(replay_t *self, const replay_trace_t *trace, replay_plan_t plan);

/* Adds the next frame on the bus that the firmware may have read and refused without recording its counter. Returns
 * false if there is none. */
bool replay_read_refused(replay_t *self);

/* Sets the times of reception in the inbox: see replay.h. */
void replay_stamp_inbox(replay_t *self, const replay_trace_t *trace);

#endif
