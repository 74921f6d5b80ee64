/* How the person's hand moves, from time-stamped samples of its pose: where it is and how fast at an instant between or
 * after them.
 *
 * Any rate from 15 to 500 Hz, irregular and with lost samples; noise and rate are measured (motion_filter.h). Between
 * samples the prediction is continuous: what a new sample changes in it fades in over one interval. When no sample
 * comes for HAND_MOTION_AWAITED_INTERVALS usual ones and HAND_MOTION_GRACE_S, the motion slows down linearly and stands
 * HAND_MOTION_GAP_S later; after a gap of more than all that, the next sample starts anew. */
#ifndef COMANIP_HAND_MOTION_H
#define COMANIP_HAND_MOTION_H

#include <stdint.h>

#include "../maths/pose.h"
#include "motion_filter.h"

#define HAND_MOTION_AWAITED_INTERVALS 2.5f
#define HAND_MOTION_GAP_S 0.05f

#define HAND_MOTION_GRACE_S 0.005f

/* From a sample's capture to its being taken over, as it is believed: what is less or more counts as these. Below 0, as
 * a latency known wrongly leads there. */
#define HAND_MOTION_LATENCY_MIN_S -0.02f
#define HAND_MOTION_LATENCY_MAX_S 0.1f

/* What the newest sample has changed in the prediction, fading from then on. */
typedef struct {
    vector3_t place, velocity;
} hand_motion_change_t;

typedef struct {
    bool is_running;                       /* since reset */
    pose_t pose;                           /* at captured_us */
    motion_filter_t translation, rotation; /* the rotation as rotation vectors from `pose` on */
    hand_motion_change_t translation_change, rotation_change;
    uint32_t captured_us, taken_us; /* of the newest sample */
    float latency_s;                /* from captured to taken, within HAND_MOTION_LATENCY_MIN_S and _MAX_S */
    float interval_s;               /* usual, between samples */
} hand_motion_t;

/* No sample yet: the identity, at rest. */
void hand_motion_init(hand_motion_t *self);

/* The tracker was lost, and its clock is not known any more: at rest in the last pose, and the next sample starts anew.
 * To be called before our own clock comes round, at most 35 minutes after the last sample. */
void hand_motion_reset(hand_motion_t *self);

/* The hand's pose (unit quaternion of either sign) as it was at captured_us, known from now_us on; both by our clock,
 * modulo 2^32. captured_us may be wrong, and jump as the tracker's clock becomes known: it costs accuracy only. A pose
 * more than 0.5 m or 1 rad from the prediction starts anew. */
void hand_motion_sample(hand_motion_t *self, const pose_t *hand, uint32_t captured_us, uint32_t now_us);

/* The hand at now_us + ahead_s, as known at now_us, which is not before the newest sample's. The quaternion's sign is
 * continuous but where a sample starts anew. */
pose_t hand_motion_pose(const hand_motion_t *self, uint32_t now_us, float ahead_s);

/* Likewise. Speeds are at most 20 m/s and 50 rad/s at the sample, and change by at most 200 m/s^2 and 1000 rad/s^2 from
 * there. They are the motion's own, without the way that a new sample's change takes to fade in. */
twist_t hand_motion_twist(const hand_motion_t *self, uint32_t now_us, float ahead_s);

#endif
