/* Receives the poses of the person's hand: see hand_tracker.h. */
#include "hand_tracker.h"

#define UNIT_TOLERANCE 1e-3f

/* Two quartz clocks drift apart by a few tens of ppm. The minimum clock offset is raised by 1 us every 5 ms (200 ppm),
 * so that it follows the drift instead of becoming outdated. */
#define CLOCK_CREEP_PERIOD_US 5000u

/* A tracker that has been stale for this long is treated as new. */
#define FORGET_US 1000000u

#define PERIOD_MIN_US 1000u
#define PERIOD_MAX_US 100000u
#define LATENCY_MAX_US 100000u

void hand_tracker_init(hand_tracker_t *self, uint32_t period_us) {
    *self = (hand_tracker_t){
        .period_us = period_us,
        .interpolates = true,
        .from = pose_identity,
        .to = pose_identity,
    };
}

void hand_tracker_interpolate(hand_tracker_t *self, bool interpolates) {
    if (interpolates && !self->interpolates) {
        self->from = self->to; /* no earlier pose was stored */
    }
    self->interpolates = interpolates;
}

void hand_tracker_status(hand_tracker_t *self, const tracker_status_t *status) {
    if (status->period_us >= PERIOD_MIN_US && status->period_us <= PERIOD_MAX_US) {
        self->period_us = status->period_us;
    }
    self->latency_us = status->latency_us < LATENCY_MAX_US ? status->latency_us : LATENCY_MAX_US;
}

/* Returns the delay of this frame relative to the fastest frame. stamp_us, received_us: when the frame was stamped and
 * received, by the tracker's and the firmware's clock, respectively, modulo 2^32. */
static uint32_t lateness_us(hand_tracker_t *self, uint32_t stamp_us, uint32_t received_us) {
    uint32_t offset_us = received_us - stamp_us;
    if (!self->has_clock) {
        self->has_clock = true;
        self->clock_offset_us = offset_us;
        self->creep_stamp_us = stamp_us;
        return 0u;
    }
    uint32_t creep_us = (stamp_us - self->creep_stamp_us) / CLOCK_CREEP_PERIOD_US;
    self->creep_stamp_us += creep_us * CLOCK_CREEP_PERIOD_US; /* the remainder is carried over to the next frame */
    uint32_t least_us = self->clock_offset_us + creep_us;
    int32_t above_least_us = (int32_t)(offset_us - least_us);
    self->clock_offset_us = above_least_us < 0 ? offset_us : least_us;
    return above_least_us < 0 ? 0u : (uint32_t)above_least_us;
}

bool hand_tracker_receive(hand_tracker_t *self, const hand_pose_t *pose, uint32_t received_us, uint32_t now_us) {
    if (!pose->valid || !quaternion_is_unit(pose->rotation, UNIT_TOLERANCE)) {
        return false;
    }
    if (self->has_pose && (int32_t)(pose->t_us - self->last_stamp_us) <= 0) {
        return false;
    }
    self->age_at_reception_us = lateness_us(self, pose->t_us, received_us);
    self->last_stamp_us = pose->t_us;
    self->received_us = received_us;

    pose_t sample = {quaternion_normalise(pose->rotation), pose->position_m};
    if (self->interpolates) {
        self->from = self->has_pose ? hand_tracker_pose(self, now_us) : sample;
        sample.rotation = quaternion_align(sample.rotation, self->from.rotation);
    }
    self->to = sample;
    self->blend_start_us = now_us;
    self->has_pose = true;
    return true;
}

uint32_t hand_tracker_age_us(const hand_tracker_t *self, uint32_t now_us) {
    if (!self->has_pose) {
        return UINT32_MAX;
    }
    return now_us - self->received_us + self->age_at_reception_us;
}

uint32_t hand_tracker_captured_us(const hand_tracker_t *self) {
    return self->received_us - self->age_at_reception_us - self->latency_us;
}

bool hand_tracker_check_stale(hand_tracker_t *self, uint32_t now_us, float stale_periods) {
    float age_limit_us = stale_periods * (float)self->period_us * (self->stale ? 0.5f : 1.0f);
    bool stale = !self->has_pose || (float)hand_tracker_age_us(self, now_us) > age_limit_us;
    if (stale && !self->stale) {
        self->stale_since_us = now_us;
    }
    self->stale = stale;
    if (stale && self->has_pose && now_us - self->stale_since_us > FORGET_US) {
        self->has_pose = false;
        self->has_clock = false;
    }
    return stale;
}

pose_t hand_tracker_pose(const hand_tracker_t *self, uint32_t now_us) {
    uint32_t elapsed_us = now_us - self->blend_start_us;
    if (!self->interpolates || elapsed_us >= self->period_us) {
        return self->to;
    }
    return pose_interpolate(self->from, self->to, (float)elapsed_us / (float)self->period_us);
}
