/* Estimates the pose and twist of the person's hand at any time from timestamped samples of its pose.
 *
 * Samples may arrive at any rate from 15 to 500 Hz, irregularly and with losses, because their mean interval and their
 * noise (motion_filter.h) are measured. The change caused by a new sample fades in over one interval, so that the
 * prediction does not jump. If no sample arrives for HAND_MOTION_AWAITED_INTERVALS mean intervals plus
 * HAND_MOTION_GRACE_S, the motion slows down linearly, and it is at rest HAND_MOTION_GAP_S later. After a longer gap,
 * the next sample restarts the motion, and the prediction jumps to that sample. */
#ifndef COMANIP_HAND_MOTION_H
#define COMANIP_HAND_MOTION_H

#include <stdint.h>

#include "../maths/pose.h"
#include "motion_filter.h"

#define HAND_MOTION_AWAITED_INTERVALS 2.5f
#define HAND_MOTION_GAP_S 0.05f
#define HAND_MOTION_GRACE_S 0.005f

/* The time from the capture of a sample to its use is clamped to this range. The computed time can be negative, because
 * a reported latency can be wrong. */
#define HAND_MOTION_LATENCY_MIN_S -0.02f
#define HAND_MOTION_LATENCY_MAX_S 0.1f

/* The prediction without the newest sample minus the prediction with it. This difference is added to the prediction and
 * fades to 0 over one interval, so that the prediction does not jump. */
typedef struct {
    vector3_t displacement, velocity;
} hand_motion_change_t;

typedef struct {
    bool is_running;                       /* there has been a sample since the reset */
    pose_t pose;                           /* pose at captured_us */
    motion_filter_t translation, rotation; /* the rotation is filtered as rotation vectors relative to `pose` */
    hand_motion_change_t translation_change, rotation_change;
    uint32_t captured_us, taken_us; /* times of the newest sample */
    float latency_s;                /* taken_us - captured_us, within HAND_MOTION_LATENCY_MIN_S and _MAX_S */
    float interval_s;               /* running mean of the interval between samples */
} hand_motion_t;

/* Initialises the estimate to the identity pose at rest, with no sample taken yet. */
void hand_motion_init(hand_motion_t *self);

/* Call this when the tracker is lost and its clock is unknown. The hand is then at rest in its last pose, and the next
 * sample restarts the motion. This must be called at most 35 minutes after the last sample, because longer differences
 * between times overflow. */
void hand_motion_reset(hand_motion_t *self);

/* Takes the hand's pose (a unit quaternion of either sign), captured at captured_us and received at now_us, both by the
 * firmware's clock, modulo 2^32. If captured_us is wrong or jumps, as it does while the tracker's clock is being
 * estimated, only the accuracy suffers. A pose more than 0.5 m or 1 rad from the prediction restarts the motion. */
void hand_motion_sample(hand_motion_t *self, const pose_t *hand, uint32_t captured_us, uint32_t now_us);

/* Returns the hand's pose at now_us + ahead_s, as known at now_us, which must not be before the newest sample. The
 * quaternion's sign is continuous except at a restart. */
pose_t hand_motion_pose(const hand_motion_t *self, uint32_t now_us, float ahead_s);

/* Returns the hand's twist at now_us + ahead_s. At the sample, the speeds are at most 20 m/s and 50 rad/s; after it,
 * they change by at most 200 m/s^2 and 1000 rad/s^2. The rate at which the displacement of a hand_motion_change_t fades
 * is not included in the twist. */
twist_t hand_motion_twist(const hand_motion_t *self, uint32_t now_us, float ahead_s);

#endif
