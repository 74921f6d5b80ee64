/* Replays a log of the bus. Each tick of the firmware runs again with the frames that the firmware originally read in
 * that tick. The TickTrace of the tick records which frames these were.
 *
 * The parameters at boot, which the firmware may have loaded from its store, are taken from the ParameterValue frames
 * that it sends at boot. The result of a save is taken from the recorded answer.
 *
 * The timestamps in the log are ignored, because they usually do not come from the firmware's clock. The trace contains
 * everything that depends on when a frame was received:
 *
 *   hand_age_us      A HandPose gets the time of reception now_us - hand_age_us. The firmware then computes the age and
 *                    the clock offset that were recorded. The true time of reception may be later, because hand_age_us
 *                    includes the delay of the frame. If hand_age_us is TRACE_AGE_MAX_US, the firmware had no pose at
 *                    the end of the tick. On CAN FD the HandPose then gets the time now_us. On classic CAN the
 *                    firmware extends the tracker's timestamp by the time since the previous pose. There the HandPose
 *                    gets the time of the previous pose plus the time between the two ticks that read these poses.
 *   drives_fresh     A JointState gets the oldest time of reception with which its drive is fresh in every tick whose
 *                    trace reports fresh drives.
 *   rejected_frames  The increase of this signal in a tick is the number of frames that the tick read but whose counter
 *                    the trace does not contain (wrong CRC, wrong length or repeated).
 *
 * On classic CAN, the firmware gets all parts of a message in the tick that originally read the last part.
 *
 * A log of another build is compared only in the messages and parameters that both builds have. Frame kinds that are
 * left out reach the firmware, but are not compared. The counters of ParameterValue are not compared either. */
#ifndef COMANIP_REPLAY_H
#define COMANIP_REPLAY_H

#include "outbox.h"

#define REPLAY_NO_FRAME 0xFFFFFFFFu

typedef enum {
    REPLAY_EQUAL = 0,     /* no difference so far */
    REPLAY_DIFFERENT = 1, /* the firmware sends `sent`, which has other bytes than the frame at `place` */
    REPLAY_NOT_SENT = 2,  /* the firmware does not send the frame at `place` */
    REPLAY_NOT_IN_LOG =
        3,              /* the firmware sends `sent` in the tick at `place`, but the log contains no such frame there */
    REPLAY_DAMAGED = 4, /* the firmware read or sent the frame at `place`, but its CRC is wrong in the log */
    REPLAY_LOST = 5,    /* according to the TickTrace at `place`, the tick read a frame that is not in the log, or more
                         * frames than a tick can read; `sent` has the id of the missing frame (in the second case, of
                         * OperatorCommand) and, as its only byte, the counter in the TickTrace */
} replay_result_t;

/* All frames with one id. */
typedef struct {
    const frame_description_t *description;
    frame_kind_t kind;
    uint32_t cursor; /* index of the next frame that the firmware is expected to read or send */
} replay_stream_t;

#define REPLAY_MAX_STREAMS (CLASSIC_FRAME_COUNT + FRAME_KIND_COUNT)
#define REPLAY_NO_STREAM REPLAY_MAX_STREAMS
#define REPLAY_TRACE_PARTS CLASSIC_MAX_PARTS

typedef struct {
    /* The log, owned by the caller: standard frames of up to 64 bytes in the order of the bus. Timestamps are ignored.
     */
    const can_frame_t *log;
    uint32_t count;
    uint8_t *stream_of; /* per frame: number of its stream, or REPLAY_NO_STREAM for a foreign id */
    uint32_t *next;     /* per frame: index of the next frame of the same stream */
    bool to_firmware[FRAME_KIND_COUNT];
    bool from_firmware[FRAME_KIND_COUNT];
    bool left_out[FRAME_KIND_COUNT]; /* frame kinds that are not compared */
    bool is_of_another_build;
    bool has_parameter[PARAMETER_NUMBERS]; /* parameters of the build that recorded the log */
    can_profile_t profile;
    replay_stream_t stream[REPLAY_MAX_STREAMS];
    int stream_count;

    controller_t controller;
    controller_t before; /* state before this tick, restored when the tick is tried again */
    controller_inbox_t inbox, received;
    outbox_t outbox;
    uint32_t place_of[CONTROLLER_INBOX_FRAMES]; /* index in the log of each frame in the inbox */
    replay_stream_t stream_before[REPLAY_MAX_STREAMS];
    uint32_t pose_tick_us; /* now_us of the last tick that read a valid HandPose */

    replay_result_t result;
    uint32_t place;
    can_frame_t sent;
    uint32_t tick_place; /* index of the next TickTrace (of its first part); REPLAY_NO_FRAME if there is none */
    uint32_t former_tick_place;
    uint32_t ticks, boots, fed, compared;
} replay_t;

/* Return the build hash, trace hash and trace version of this core. */
uint64_t replay_build_hash(void);
uint32_t replay_trace_hash(void);
uint8_t replay_trace_version(void);

/* to_firmware, from_firmware: for each frame kind, whether the firmware receives or sends it, as in the DBC.
 * stream_of, next: room for `count` elements each. */
void replay_init(replay_t *self, const arm_ik_t *ik, can_profile_t profile, const can_frame_t log[], uint32_t count,
                 uint8_t stream_of[], uint32_t next[], const bool to_firmware[], const bool from_firmware[]);

/* Prepares for a log of another build. Call between replay_init() and replay_run(). has_parameter: parameters of the
 * other build. */
void replay_other_build(replay_t *self, const bool has_parameter[PARAMETER_NUMBERS]);

/* Excludes frame kinds from the comparison. Call between replay_init() and replay_run(). */
void replay_leave_out(replay_t *self, const bool left_out[FRAME_KIND_COUNT]);

/* Replays the ticks whose TickTrace is before the index `end`, up to the first difference. Returns true if no
 * difference was found and ticks are left. */
bool replay_run(replay_t *self, uint32_t end);

/* Finds recorded frames that the replay has not sent. Call after the last tick. If the log ends within a tick, the
 * frames after the last replayed TickTrace are ignored. */
void replay_finish(replay_t *self);

#endif
