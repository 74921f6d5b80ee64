/* What a tick of the recorded firmware had read, as its TickTrace tells; a part of the replay. */
#ifndef COMANIP_REPLAY_INBOX_H
#define COMANIP_REPLAY_INBOX_H

#include "replay_log.h"

/* Where the firmware read less than the bus brought, for its queue was full after a pause, the log does not say which
 * frames it had lost. In this order it is tried with which of them the tick sends the recorded TickTrace. */
typedef enum {
    REPLAY_READ_ALL,            /* up to the traced counter */
    REPLAY_READ_BRIDGED_STATES, /* of states just so many that no counter jumps by more than end-to-end protection
                                   allows */
    REPLAY_READ_NEWEST_STATES,  /* of states the newest alone */
    REPLAY_READ_NEWEST,         /* of poses as well */
    REPLAY_READ_PLANS
} replay_plan_t;

/* Of several, the difference that stands first in the log counts. */
void replay_end(replay_t *self, replay_result_t result, uint32_t place);

/* REPLAY_LOST: this frame. */
void replay_note_lost(replay_t *self, const replay_stream_t *stream, uint8_t counter);

/* Takes the frames up to the traced counters. False: there is one that the log does not have (then the replay has
 * ended), or they are more than a tick reads. */
bool replay_fill_inbox(replay_t *self, const replay_trace_t *trace, replay_plan_t plan);

/* One more: the next in the order of the bus that the firmware may have read and refused without following its counter.
 */
bool replay_read_refused(replay_t *self);

/* The times of reception, as far as they matter: see replay.h. */
void replay_stamp_inbox(replay_t *self, const replay_trace_t *trace);

#endif
