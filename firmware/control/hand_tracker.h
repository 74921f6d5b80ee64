/* The human's hand: from tracker frames at the tracker's pace to a pose with an age at each tick. */
#ifndef COMANIP_HAND_TRACKER_H
#define COMANIP_HAND_TRACKER_H

#include "../protocol/can_protocol.h"

typedef struct {
    uint32_t period_us;  /* as announced by TrackerStatus */
    uint32_t latency_us; /* from the measurement to the frame, as announced by TrackerStatus */
    bool has_pose;
    bool has_clock;
    bool stale;
    uint32_t stale_since_us;
    uint32_t clock_offset_us;     /* least (reception - stamp) seen, modulo 2^32: the fastest way a frame ever took */
    uint32_t creep_stamp_us;      /* tracker's clock, up to which the least offset has been let creep */
    uint32_t last_stamp_us;       /* tracker's clock, of the newest pose */
    uint32_t received_us;         /* of the newest valid pose */
    uint32_t age_at_reception_us; /* how much later it came than the fastest frame */
    bool interpolates;
    uint32_t blend_start_us;
    pose_t from, to; /* interpolated over one period: marker in the tracker frame */
} hand_tracker_t;

/* period_us: until the tracker announces its own. */
void hand_tracker_init(hand_tracker_t *self, uint32_t period_us);

/* Whether hand_tracker_pose() interpolates, as it does from the beginning. If not, it is the newest pose, and to
 * receive one costs less. */
void hand_tracker_interpolate(hand_tracker_t *self, bool interpolates);

/* Takes over the announced period, if it is within 1 and 100 ms: with a longer one, blind cooperation could last long;
 * and the announced latency, up to 100 ms. */
void hand_tracker_status(hand_tracker_t *self, const tracker_status_t *status);

/* A HandPose received at received_us (not after now_us), taken over at now_us. Refused, and false, if it is marked
 * invalid, is not a unit quaternion within 1e-3, or is older by its stamp than one already taken. */
bool hand_tracker_receive(hand_tracker_t *self, const hand_pose_t *pose, uint32_t received_us, uint32_t now_us);

/* Age of the newest valid pose: time since its reception, plus how much later than the fastest frame it came, by the
 * tracker's own clock (so a constant clock offset and any transport time common to all frames cancel). UINT32_MAX
 * without a pose. */
uint32_t hand_tracker_age_us(const hand_tracker_t *self, uint32_t now_us);

/* When the newest valid pose was measured, by our clock: the fastest frame so far took just the announced latency. */
uint32_t hand_tracker_captured_us(const hand_tracker_t *self);

/* The newest valid pose: the marker in the tracker frame. The identity at first. */
static inline const pose_t *hand_tracker_newest(const hand_tracker_t *self) {
    return &self->to;
}

/* No valid pose for stale_periods of the tracker's own periods; and, once stale, until one comes with at most half that
 * age, so that a pose that is late again and again does not flap. Call it once per tick: what has been stale for a
 * second is forgotten, and with it the tracker's clock, so that neither a restarted or stepped tracker clock nor our
 * own that comes round in 71 minutes keeps the arm in hold or passes for fresh. */
bool hand_tracker_check_stale(hand_tracker_t *self, uint32_t now_us, float stale_periods);

/* The marker's pose in the tracker frame, moved from the last sample to the newest over one tracker period: a
 * continuous path from samples slower than the tick, at the cost of that period as latency. The identity at first. */
pose_t hand_tracker_pose(const hand_tracker_t *self, uint32_t now_us);

#endif
