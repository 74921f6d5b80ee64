/* The person's hand: computes a pose and its age in each tick from frames at the tracker's rate. */
#ifndef COMANIP_HAND_TRACKER_H
#define COMANIP_HAND_TRACKER_H

#include "../protocol/can_protocol.h"

typedef struct {
    uint32_t period_us;  /* as reported by TrackerStatus */
    uint32_t latency_us; /* from the measurement to the frame, as reported by TrackerStatus */
    bool has_pose;
    bool has_clock;
    bool stale;
    uint32_t stale_since_us;
    uint32_t clock_offset_us;     /* least (reception - stamp) so far, modulo 2^32: that of the fastest frame */
    uint32_t creep_stamp_us;      /* tracker's clock up to which the least offset has been raised */
    uint32_t last_stamp_us;       /* stamp of the newest pose, by the tracker's clock */
    uint32_t received_us;         /* reception of the newest valid pose */
    uint32_t age_at_reception_us; /* its delay compared with the fastest frame */
    bool interpolates;
    uint32_t blend_start_us;
    pose_t from, to; /* marker in the tracker frame, interpolated over one period */
} hand_tracker_t;

/* period_us: used until the tracker reports its period. */
void hand_tracker_init(hand_tracker_t *self, uint32_t period_us);

/* Switches the interpolation of hand_tracker_pose() on (the default) or off. Without it, hand_tracker_pose() returns
 * the newest pose, and reception costs less. */
void hand_tracker_interpolate(hand_tracker_t *self, bool interpolates);

/* Takes over the reported period if it is within 1 and 100 ms (a longer one would let the arm cooperate too long
 * without a pose), and the reported latency up to 100 ms. */
void hand_tracker_status(hand_tracker_t *self, const tracker_status_t *status);

/* Takes a HandPose that was received at received_us (not after now_us). Returns false and ignores it if it is marked
 * invalid, its quaternion is not unit within 1e-3, or its stamp is not newer than the last one. */
bool hand_tracker_receive(hand_tracker_t *self, const hand_pose_t *pose, uint32_t received_us, uint32_t now_us);

/* The age of the newest valid pose: the time since its reception, plus its delay compared with the fastest frame by the
 * tracker's clock. A constant clock offset and a transport time common to all frames cancel. UINT32_MAX without a
 * pose. */
uint32_t hand_tracker_age_us(const hand_tracker_t *self, uint32_t now_us);

/* The time of measurement of the newest valid pose by the firmware's clock, if the fastest frame so far had the
 * reported latency. */
uint32_t hand_tracker_captured_us(const hand_tracker_t *self);

/* The newest valid pose: the marker in the tracker frame. The identity at first. */
static inline const pose_t *hand_tracker_newest(const hand_tracker_t *self) {
    return &self->to;
}

/* True if the newest valid pose is older than stale_periods tracker periods. Once stale, the tracker stays stale until
 * a pose has at most half that age (hysteresis). Call it once per tick: after a second without a fresh pose, the pose
 * and the estimate of the tracker's clock are discarded, so that a restarted tracker clock does not keep the arm in
 * hold, and an old pose does not appear fresh when the firmware's clock wraps after 71 minutes. */
bool hand_tracker_check_stale(hand_tracker_t *self, uint32_t now_us, float stale_periods);

/* The marker's pose in the tracker frame, interpolated from the last sample to the newest over one tracker period. This
 * gives a continuous path at the cost of one period of latency. The identity at first. */
pose_t hand_tracker_pose(const hand_tracker_t *self, uint32_t now_us);

#endif
