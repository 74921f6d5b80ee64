/* Predicts the motion of the person's hand: see hand_motion.h. */
#include "hand_motion.h"

#include "../maths/float_bits.h"

static const motion_filter_scale_t translation_scale = {
    .noise_variance = 5e-5f * 5e-5f, .velocity_max = 20.0f, .acceleration_max = 200.0f};
static const motion_filter_scale_t rotation_scale = {
    .noise_variance = 1e-3f * 1e-3f, .velocity_max = 50.0f, .acceleration_max = 1000.0f};

#define INTERVAL_FIRST_S 0.01f
#define INTERVAL_MIN_S 0.0005f
#define INTERVAL_MAX_S 0.1f
#define INTERVAL_WEIGHT 0.1f /* weight of a new interval in the running mean of the intervals */

/* If a pose is farther than this from the prediction, in position or in angle, the motion restarts there. */
#define JUMP_M 0.5f
#define JUMP_COS_HALF 0.87758256f /* cosine of half of 1 rad */

static const vector3_t zero = {0.0f, 0.0f, 0.0f};

static float seconds_from(uint32_t from_us, uint32_t to_us) {
    return 1e-6f * (float)(int32_t)(to_us - from_us);
}

static vector3_t difference(vector3_t a, vector3_t b) {
    return vector3_add(a, vector3_scale(b, -1.0f));
}

/* Moves a pose by a displacement and a rotation vector. */
static inline pose_t displace(pose_t pose, vector3_t way_m, vector3_t turn_rad) {
    return (pose_t){
        quaternion_multiply(quaternion_from_rotation_vector(turn_rad), pose.rotation),
        vector3_add(pose.translation_m, way_m),
    };
}

/* Returns the rotation vector of a unit quaternion with w > 0, from the series of 2 asin(|v|), where v is the vector
 * part. For angles up to 1 rad, the error is below 1e-4 rad; at pi, the result is 18 % too short. */
static vector3_t rotation_vector(quaternion_t q) {
    const vector3_t v = {q.x, q.y, q.z};
    const float square = vector3_dot(v, v);
    return vector3_scale(v, 2.0f + square * (0.33333334f + square * (0.15f + square * 0.089285714f)));
}

/* Returns the rotation from b to a, in the axes of their common frame. */
static quaternion_t turn_between(quaternion_t a, quaternion_t b) {
    return quaternion_align(quaternion_multiply(a, quaternion_conjugate(b)), quaternion_identity);
}

/* Returns the time from a sample to the start of a gap, which applies if no further sample arrives. */
static float awaited_s(const hand_motion_t *self) {
    return HAND_MOTION_AWAITED_INTERVALS * self->interval_s + HAND_MOTION_GRACE_S;
}

/* How the motion is extrapolated to a point in time. */
typedef struct {
    motion_filter_ahead_t horizon;
    float pace; /* factor on the velocity; falls from 1 to 0 in a gap */
    float left; /* remaining share of the hand_motion_change_t; falls from 1 to 0 within one interval */
} schedule_t;

static inline schedule_t schedule(const hand_motion_t *self, uint32_t now_us, float ahead_s) {
    const float since_s = seconds_from(self->taken_us, now_us);
    const float left = 1.0f - since_s / self->interval_s;
    float horizon_s = self->latency_s + since_s + ahead_s;
    float pace = 1.0f;
    const float overdue_s = since_s - awaited_s(self);
    if (float_is_below(0.0f, overdue_s)) {
        const float gap_s = float_is_below(overdue_s, HAND_MOTION_GAP_S) ? overdue_s : HAND_MOTION_GAP_S;
        pace = 1.0f - gap_s * (1.0f / HAND_MOTION_GAP_S);
        horizon_s = self->latency_s + awaited_s(self) + 0.5f * gap_s * (1.0f + pace) + pace * ahead_s;
    }
    return (schedule_t){motion_filter_ahead(horizon_s), pace, float_is_below(0.0f, left) ? left : 0.0f};
}

static inline vector3_t displacement_at(const motion_filter_t *filter, const hand_motion_change_t *change,
                                        const schedule_t *at) {
    return vector3_add(motion_filter_displacement(filter, &at->horizon), vector3_scale(change->displacement, at->left));
}

static inline vector3_t velocity_at(const motion_filter_t *filter, const hand_motion_change_t *change,
                                    const schedule_t *at) {
    return vector3_add(vector3_scale(motion_filter_velocity(filter, &at->horizon), at->pace),
                       vector3_scale(change->velocity, at->left));
}

void hand_motion_init(hand_motion_t *self) {
    *self = (hand_motion_t){.pose = pose_identity, .interval_s = INTERVAL_FIRST_S};
    motion_filter_init(&self->translation, &translation_scale);
    motion_filter_init(&self->rotation, &rotation_scale);
}

static void come_to_rest(hand_motion_t *self) {
    motion_filter_restart(&self->translation);
    motion_filter_restart(&self->rotation);
    self->translation_change = self->rotation_change = (hand_motion_change_t){zero, zero};
}

void hand_motion_reset(hand_motion_t *self) {
    come_to_rest(self);
    self->is_running = false;
}

/* Restarts the motion at this pose. If the sample arrived in time, the prediction moves gradually from its present pose
 * to the new one. After a gap, and at the first sample, the prediction jumps to the new pose. */
static void restart(hand_motion_t *self, const pose_t *hand, uint32_t now_us, bool in_time) {
    const pose_t pose = hand_motion_pose(self, now_us, 0.0f);
    const twist_t motion = hand_motion_twist(self, now_us, 0.0f);
    come_to_rest(self);
    if (in_time) {
        self->translation_change.displacement = difference(pose.translation_m, hand->translation_m);
        self->rotation_change.displacement = rotation_vector(turn_between(pose.rotation, hand->rotation));
        self->translation_change.velocity = motion.velocity_mps;
        self->rotation_change.velocity = motion.angular_velocity_radps;
    }
    self->pose = *hand;
    self->is_running = true;
}

/* The extrapolation and the time spans needed to process a new sample. */
typedef struct {
    schedule_t before;              /* the extrapolation to now, without the new sample */
    motion_filter_ahead_t interval; /* from the last sample to the new one */
    motion_filter_ahead_t latency;  /* from the new sample to now */
} sample_times_t;

/* Updates the filter. moved: the displacement that the filter predicts for the interval from the last sample to this
 * one. innovation: the sample minus the pose predicted with that displacement. Sets *change to the old prediction minus
 * the new one. Rotation vectors are added as if rotations commuted, so the prediction is continuous only to first order
 * in the angle of extrapolation. */
static inline vector3_t update(motion_filter_t *filter, hand_motion_change_t *change,
                               const motion_filter_scale_t *scale, vector3_t moved, vector3_t innovation,
                               const sample_times_t *at) {
    const vector3_t old_displacement = displacement_at(filter, change, &at->before);
    const vector3_t old_velocity = velocity_at(filter, change, &at->before);
    const vector3_t correction = motion_filter_update(filter, scale, innovation, &at->interval);
    const vector3_t new_displacement =
        vector3_add(vector3_add(moved, correction), motion_filter_displacement(filter, &at->latency));
    change->displacement = difference(old_displacement, new_displacement);
    change->velocity = difference(old_velocity, motion_filter_velocity(filter, &at->latency));
    return correction;
}

/* Continues the motion with this pose. Returns false, and changes nothing, if the pose is too far from the
 * prediction. */
static bool continue_motion(hand_motion_t *self, const pose_t *hand, float interval_s, uint32_t now_us,
                            float latency_s) {
    const sample_times_t at = {schedule(self, now_us, 0.0f), motion_filter_ahead(interval_s),
                               motion_filter_ahead(latency_s)};
    const vector3_t moved_m = motion_filter_displacement(&self->translation, &at.interval);
    const vector3_t turned_rad = motion_filter_displacement(&self->rotation, &at.interval);
    const pose_t predicted = displace(self->pose, moved_m, turned_rad);
    const vector3_t way_m = difference(hand->translation_m, predicted.translation_m);
    const quaternion_t turn = turn_between(hand->rotation, predicted.rotation);
    if (!(vector3_dot(way_m, way_m) < JUMP_M * JUMP_M && turn.w > JUMP_COS_HALF)) { /* also for NaN */
        return false;
    }
    const vector3_t correction_m =
        update(&self->translation, &self->translation_change, &translation_scale, moved_m, way_m, &at);
    const vector3_t correction_rad =
        update(&self->rotation, &self->rotation_change, &rotation_scale, turned_rad, rotation_vector(turn), &at);
    const quaternion_t corrected = {1.0f, 0.5f * correction_rad.x, 0.5f * correction_rad.y,
                                    0.5f * correction_rad.z}; /* normalised below */
    self->pose.translation_m = vector3_add(predicted.translation_m, correction_m);
    self->pose.rotation = quaternion_normalise(quaternion_multiply(corrected, predicted.rotation));
    return true;
}

/* Updates the running mean of the interval. The mean grows by at most a tenth per sample, so that a gap is not mistaken
 * for a slow tracker. */
static void learn_interval(hand_motion_t *self, float interval_s) {
    const float longest_s = 2.0f * self->interval_s;
    const float seen_s = float_is_below(interval_s, longest_s) ? interval_s : longest_s;
    const float learnt_s = self->interval_s + (seen_s - self->interval_s) * INTERVAL_WEIGHT;
    self->interval_s = float_is_below(learnt_s, INTERVAL_MAX_S) ? learnt_s : INTERVAL_MAX_S;
}

static float bounded_latency_s(float age_s) {
    if (age_s < HAND_MOTION_LATENCY_MIN_S) {
        return HAND_MOTION_LATENCY_MIN_S;
    }
    return float_is_below(age_s, HAND_MOTION_LATENCY_MAX_S) ? age_s : HAND_MOTION_LATENCY_MAX_S;
}

void hand_motion_sample(hand_motion_t *self, const pose_t *hand, uint32_t captured_us, uint32_t now_us) {
    const float measured_s = seconds_from(self->captured_us, captured_us);
    const float interval_s = float_is_below(measured_s, INTERVAL_MIN_S) ? INTERVAL_MIN_S : measured_s;
    const float latency_s = bounded_latency_s(seconds_from(captured_us, now_us));
    const bool in_time = self->is_running && float_is_below(interval_s, awaited_s(self) + HAND_MOTION_GAP_S);
    const bool was_running = self->is_running;
    if (!(in_time && continue_motion(self, hand, interval_s, now_us, latency_s))) {
        restart(self, hand, now_us, in_time);
    }
    if (was_running) {
        learn_interval(self, interval_s);
    }
    self->latency_s = latency_s;
    self->captured_us = captured_us;
    self->taken_us = now_us;
}

pose_t hand_motion_pose(const hand_motion_t *self, uint32_t now_us, float ahead_s) {
    const schedule_t at = schedule(self, now_us, ahead_s);
    return displace(self->pose, displacement_at(&self->translation, &self->translation_change, &at),
                    displacement_at(&self->rotation, &self->rotation_change, &at));
}

twist_t hand_motion_twist(const hand_motion_t *self, uint32_t now_us, float ahead_s) {
    const schedule_t at = schedule(self, now_us, ahead_s);
    return (twist_t){velocity_at(&self->translation, &self->translation_change, &at),
                     velocity_at(&self->rotation, &self->rotation_change, &at)};
}
