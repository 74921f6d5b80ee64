/* Computes the pose of the person's hand and the age of that pose in each tick, from frames that arrive at the
 * tracker's rate. */
#ifndef COMANIP_HAND_TRACKER_H
#define COMANIP_HAND_TRACKER_H

#include "../protocol/can_protocol.h"

typedef struct {
    uint32_t period_us;  /* tracker's period, as reported by TrackerStatus */
    uint32_t latency_us; /* time from the measurement to the frame, as reported by TrackerStatus */
    bool has_pose;
    bool has_clock;
    bool stale;
    uint32_t stale_since_us;
    uint32_t clock_offset_us;     /* minimum of (reception - stamp) so far, modulo 2^32 */
    uint32_t creep_stamp_us;      /* tracker's time up to which the minimum offset has been raised */
    uint32_t last_stamp_us;       /* stamp of the newest pose, by the tracker's clock */
    uint32_t received_us;         /* time of reception of the newest valid pose */
    uint32_t age_at_reception_us; /* that pose's delay relative to the fastest frame */
    bool interpolates;
    uint32_t blend_start_us;
    pose_t from, to; /* poses of the marker in the tracker frame; hand_tracker_pose() interpolates between them */
} hand_tracker_t;

/* period_us: used until the tracker reports its period. */
void hand_tracker_init(hand_tracker_t *self, uint32_t period_us);

/* Switches the interpolation of hand_tracker_pose() on (the default) or off. Without interpolation, hand_tracker_pose()
 * returns the newest pose, and reception costs less. */
void hand_tracker_interpolate(hand_tracker_t *self, bool interpolates);

/* Adopts the reported period if it is from 1 to 100 ms (with a longer one, the arm would cooperate too long without a
 * pose), and the reported latency, clamped to 100 ms. */
void hand_tracker_status(hand_tracker_t *self, const tracker_status_t *status);

/* Takes a HandPose that was received at received_us (not after now_us). Ignores it and returns false if it is marked
 * invalid, its quaternion is not unit within 1e-3, or its stamp is not newer than the last one. */
bool hand_tracker_receive(hand_tracker_t *self, const hand_pose_t *pose, uint32_t received_us, uint32_t now_us);

/* Returns the age of the newest valid pose: the time since its reception plus its delay relative to the fastest frame.
 * The delay is derived from the frames' stamps. A constant clock offset and a transport time common to all frames
 * cancel out. Returns UINT32_MAX if there is no pose. */
uint32_t hand_tracker_age_us(const hand_tracker_t *self, uint32_t now_us);

/* Returns the time, by the firmware's clock, at which the newest valid pose was measured, assuming that the fastest
 * frame so far had the reported latency. */
uint32_t hand_tracker_captured_us(const hand_tracker_t *self);

/* Returns the newest valid pose of the marker in the tracker frame, or the identity if there has been none. */
static inline const pose_t *hand_tracker_newest(const hand_tracker_t *self) {
    return &self->to;
}

/* Returns true if the newest valid pose is older than stale_periods tracker periods. Once stale, the tracker remains
 * stale until a pose is at most half that old (hysteresis). Call it once per tick: after a second without a fresh pose,
 * it discards the pose and the estimate of the tracker's clock. Otherwise a restarted tracker clock would keep the arm
 * in hold, and an old pose would look fresh when the firmware's clock wraps after 71 minutes. */
bool hand_tracker_check_stale(hand_tracker_t *self, uint32_t now_us, float stale_periods);

/* Returns the marker's pose in the tracker frame. When a sample arrives, the returned pose starts to move towards the
 * sample, and reaches it after one tracker period. The path is continuous, at the cost of one period of latency.
 * Returns the identity if there has been no pose. */
pose_t hand_tracker_pose(const hand_tracker_t *self, uint32_t now_us);

#endif
