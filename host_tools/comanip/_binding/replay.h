/* Replays a recorded bus: runs the firmware again with the frames that each of its ticks had read. The TickTrace of a
 * tick records which frames these were.
 *
 * The parameters at boot, which may come from the store, are those of the firmware's announcement. The outcome of a
 * save is that of the recorded answer.
 *
 * The times of the log are not used, because they are usually not by the firmware's clock. The effects of a frame's
 * time of reception are in the trace:
 *
 * hand_age_us      A HandPose is stamped now - hand_age. This gives the recorded clock offset and age whatever the true
 *                    stamp was, because both follow from now, the age and the tracker's stamp.
 *   drives_fresh     A JointState gets the oldest stamp with which its drive is fresh as long as the trace reports it.
 *   rejected_frames  Determines how many frames without a recorded counter (wrong CRC or length, repeated) the tick had
 *                    read.
 *
 * On classic CAN all parts of a message are read in the tick that had read the last of them.
 *
 * A log of another build is compared as far as both builds agree. Frame kinds that are left out are fed, but not
 * compared. Of ParameterValue, counters and parameters that one of the builds does not have are not compared. */
#ifndef COMANIP_REPLAY_H
#define COMANIP_REPLAY_H

#include "outbox.h"

#define REPLAY_NO_FRAME 0xFFFFFFFFu

typedef enum {
    REPLAY_EQUAL = 0,     /* no difference so far */
    REPLAY_DIFFERENT = 1, /* the firmware sends another frame at `place` */
    REPLAY_NOT_SENT = 2,  /* the firmware does not send the frame at `place` */
    REPLAY_NOT_IN_LOG =
        3, /* the firmware sends `sent`, and the log, at `place` in that tick, has no such frame any more */
    REPLAY_DAMAGED =
        4,           /* the frame at `place` was read by the firmware or sent by it, and its CRC is wrong in the log */
    REPLAY_LOST = 5, /* the TickTrace at `place` tells of a frame, `sent` with its id and, as only byte, its counter,
                      * that the log does not have, or not among so few that a tick can read them */
} replay_result_t;

/* The frames of one id. */
typedef struct {
    const frame_description_t *description;
    frame_kind_t kind;
    uint32_t cursor; /* next frame to be read by, or expected from, the firmware */
} replay_stream_t;

#define REPLAY_MAX_STREAMS (CLASSIC_FRAME_COUNT + FRAME_KIND_COUNT)
#define REPLAY_NO_STREAM REPLAY_MAX_STREAMS
#define REPLAY_TRACE_PARTS CLASSIC_MAX_PARTS

typedef struct {
    /* The log, as the caller owns it: standard frames of up to 64 bytes in the order of the bus; timestamps are
     * ignored. */
    const can_frame_t *log;
    uint32_t count;
    uint8_t *stream_of; /* count: number of each one's stream, REPLAY_NO_STREAM for foreign ids */
    uint32_t *next;     /* count: place of the next frame of the same stream */
    bool to_firmware[FRAME_KIND_COUNT];
    bool from_firmware[FRAME_KIND_COUNT];
    bool left_out[FRAME_KIND_COUNT]; /* of the comparison */
    bool is_of_another_build;
    bool has_parameter[PARAMETER_NUMBERS]; /* the build that recorded the log */
    can_profile_t profile;
    replay_stream_t stream[REPLAY_MAX_STREAMS];
    int stream_count;

    controller_t controller;
    controller_t before; /* state before this tick, to repeat it */
    controller_inbox_t inbox, received;
    outbox_t outbox;
    uint32_t place_of[CONTROLLER_INBOX_FRAMES]; /* index in the log of each frame in the inbox */
    replay_stream_t stream_before[REPLAY_MAX_STREAMS];

    replay_result_t result;
    uint32_t place;
    can_frame_t sent;
    uint32_t tick_place; /* index of the next tick's TickTrace or of its first part; REPLAY_NO_FRAME: no further tick */
    uint32_t former_tick_place;
    uint32_t ticks, boots, fed, compared;
} replay_t;

/* Build hash, trace hash and trace version of this core. */
uint64_t replay_build_hash(void);
uint32_t replay_trace_hash(void);
uint8_t replay_trace_version(void);

/* to_firmware, from_firmware: for each frame kind, whether the firmware receives or sends it, as in the DBC.
 * stream_of, next: room for `count` elements each. */
void replay_init(replay_t *self, const arm_ik_t *ik, can_profile_t profile, const can_frame_t log[], uint32_t count,
                 uint8_t stream_of[], uint32_t next[], const bool to_firmware[], const bool from_firmware[]);

/* To be called between replay_init() and replay_run() for a log of another build. has_parameter: the parameters that
 * the other build had. */
void replay_other_build(replay_t *self, const bool has_parameter[PARAMETER_NUMBERS]);

/* To be called between replay_init() and replay_run(). left_out: frame kinds that are not compared. */
void replay_leave_out(replay_t *self, const bool left_out[FRAME_KIND_COUNT]);

/* Replays the ticks whose TickTrace is before the index `end`, up to the first difference. True if there may be further
 * ticks. */
bool replay_run(replay_t *self, uint32_t end);

/* To be called after the last tick: finds recorded frames that the replay has not sent. A log may end within a tick. */
void replay_finish(replay_t *self);

#endif
