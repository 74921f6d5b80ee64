#include "hand_motion.h"

#include "../maths/float_bits.h"

static const motion_filter_scale_t translation_scale = {
    .noise_variance = 5e-5f * 5e-5f, .velocity_max = 20.0f, .acceleration_max = 200.0f};
static const motion_filter_scale_t rotation_scale = {
    .noise_variance = 1e-3f * 1e-3f, .velocity_max = 50.0f, .acceleration_max = 1000.0f};

#define INTERVAL_FIRST_S 0.01f
#define INTERVAL_MIN_S 0.0005f
#define INTERVAL_MAX_S 0.1f
#define INTERVAL_WEIGHT 0.1f /* of a new interval in the usual one */

/* So far from the prediction, a pose is no continuation of the motion. */
#define JUMP_M 0.5f
#define JUMP_COS_HALF 0.87758256f /* of 1 rad */

static const vector3_t zero = {0.0f, 0.0f, 0.0f};

static float seconds_from(uint32_t from_us, uint32_t to_us) {
    return 1e-6f * (float)(int32_t)(to_us - from_us);
}

static vector3_t difference(vector3_t a, vector3_t b) {
    return vector3_add(a, vector3_scale(b, -1.0f));
}

/* Turns a pose's translation and rotation on. */
static inline pose_t displace(pose_t pose, vector3_t way_m, vector3_t turn_rad) {
    return (pose_t){
        quaternion_multiply(quaternion_from_rotation_vector(turn_rad), pose.rotation),
        vector3_add(pose.translation_m, way_m),
    };
}

/* The rotation vector of a unit quaternion with w > 0, by the series of 2 asin(|v|): within 1e-4 rad up to 1 rad, 18 %
 * short at pi. */
static vector3_t rotation_vector(quaternion_t q) {
    const vector3_t v = {q.x, q.y, q.z};
    const float square = vector3_dot(v, v);
    return vector3_scale(v, 2.0f + square * (0.33333334f + square * (0.15f + square * 0.089285714f)));
}

/* From b's rotation to a's, in the axes of the frame that both are in. */
static quaternion_t turn_between(quaternion_t a, quaternion_t b) {
    return quaternion_align(quaternion_multiply(a, quaternion_conjugate(b)), quaternion_identity);
}

/* So long after a sample, a gap begins. */
static float awaited_s(const hand_motion_t *self) {
    return HAND_MOTION_AWAITED_INTERVALS * self->interval_s + HAND_MOTION_GRACE_S;
}

/* How far the motion is extrapolated, how fast it still goes on, and what is left of the newest sample's change. */
typedef struct {
    motion_filter_ahead_t horizon;
    float pace, left;
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

static inline vector3_t place_at(const motion_filter_t *filter, const hand_motion_change_t *change,
                                 const schedule_t *at) {
    return vector3_add(motion_filter_displacement(filter, &at->horizon), vector3_scale(change->place, at->left));
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

static void stand(hand_motion_t *self) {
    motion_filter_restart(&self->translation);
    motion_filter_restart(&self->rotation);
    self->translation_change = self->rotation_change = (hand_motion_change_t){zero, zero};
}

void hand_motion_reset(hand_motion_t *self) {
    stand(self);
    self->is_running = false;
}

/* Where the motion is still awaited, a jump fades in; after a gap, or at first, nobody is to be led from where the hand
 * was. */
static void start_anew(hand_motion_t *self, const pose_t *hand, uint32_t now_us, bool in_time) {
    const pose_t pose = hand_motion_pose(self, now_us, 0.0f);
    const twist_t motion = hand_motion_twist(self, now_us, 0.0f);
    stand(self);
    if (in_time) {
        self->translation_change.place = difference(pose.translation_m, hand->translation_m);
        self->rotation_change.place = rotation_vector(turn_between(pose.rotation, hand->rotation));
        self->translation_change.velocity = motion.velocity_mps;
        self->rotation_change.velocity = motion.angular_velocity_radps;
    }
    self->pose = *hand;
    self->is_running = true;
}

/* Of a sample that is taken over now. */
typedef struct {
    schedule_t before;              /* now, as it was until then */
    motion_filter_ahead_t interval; /* from the last sample to it */
    motion_filter_ahead_t latency;  /* from it to now */
} sample_times_t;

/* Takes an innovation from where the filter has moved in the interval. The change that it makes in the prediction is
 * what was predicted before, less what is now. Rotation vectors are added as if turns commuted: the prediction is
 * continuous to first order in the angle that it extrapolates by. */
static inline vector3_t update(motion_filter_t *filter, hand_motion_change_t *change,
                               const motion_filter_scale_t *scale, vector3_t moved, vector3_t innovation,
                               const sample_times_t *at) {
    const vector3_t old_place = place_at(filter, change, &at->before);
    const vector3_t old_velocity = velocity_at(filter, change, &at->before);
    const vector3_t correction = motion_filter_update(filter, scale, innovation, &at->interval);
    const vector3_t new_place =
        vector3_add(vector3_add(moved, correction), motion_filter_displacement(filter, &at->latency));
    change->place = difference(old_place, new_place);
    change->velocity = difference(old_velocity, motion_filter_velocity(filter, &at->latency));
    return correction;
}

/* False: the pose is no continuation. */
static bool go_on(hand_motion_t *self, const pose_t *hand, float interval_s, uint32_t now_us, float latency_s) {
    const sample_times_t at = {schedule(self, now_us, 0.0f), motion_filter_ahead(interval_s),
                               motion_filter_ahead(latency_s)};
    const vector3_t moved_m = motion_filter_displacement(&self->translation, &at.interval);
    const vector3_t turned_rad = motion_filter_displacement(&self->rotation, &at.interval);
    const pose_t predicted = displace(self->pose, moved_m, turned_rad);
    const vector3_t way_m = difference(hand->translation_m, predicted.translation_m);
    const quaternion_t turn = turn_between(hand->rotation, predicted.rotation);
    if (!(vector3_dot(way_m, way_m) < JUMP_M * JUMP_M && turn.w > JUMP_COS_HALF)) { /* NaN is none either */
        return false;
    }
    const vector3_t correction_m =
        update(&self->translation, &self->translation_change, &translation_scale, moved_m, way_m, &at);
    const vector3_t correction_rad =
        update(&self->rotation, &self->rotation_change, &rotation_scale, turned_rad, rotation_vector(turn), &at);
    const quaternion_t corrected = {1.0f, 0.5f * correction_rad.x, 0.5f * correction_rad.y,
                                    0.5f * correction_rad.z}; /* unit below */
    self->pose.translation_m = vector3_add(predicted.translation_m, correction_m);
    self->pose.rotation = quaternion_normalise(quaternion_multiply(corrected, predicted.rotation));
    return true;
}

/* The usual interval follows by a tenth at most, so that a gap does not pass for a slow tracker. */
static void learn_interval(hand_motion_t *self, float interval_s) {
    const float longest_s = 2.0f * self->interval_s;
    const float seen_s = float_is_below(interval_s, longest_s) ? interval_s : longest_s;
    const float learnt_s = self->interval_s + (seen_s - self->interval_s) * INTERVAL_WEIGHT;
    self->interval_s = float_is_below(learnt_s, INTERVAL_MAX_S) ? learnt_s : INTERVAL_MAX_S;
}

static float believed_latency_s(float age_s) {
    if (age_s < HAND_MOTION_LATENCY_MIN_S) {
        return HAND_MOTION_LATENCY_MIN_S;
    }
    return float_is_below(age_s, HAND_MOTION_LATENCY_MAX_S) ? age_s : HAND_MOTION_LATENCY_MAX_S;
}

void hand_motion_sample(hand_motion_t *self, const pose_t *hand, uint32_t captured_us, uint32_t now_us) {
    const float measured_s = seconds_from(self->captured_us, captured_us);
    const float interval_s = float_is_below(measured_s, INTERVAL_MIN_S) ? INTERVAL_MIN_S : measured_s;
    const float latency_s = believed_latency_s(seconds_from(captured_us, now_us));
    const bool in_time = self->is_running && float_is_below(interval_s, awaited_s(self) + HAND_MOTION_GAP_S);
    const bool was_running = self->is_running;
    if (!(in_time && go_on(self, hand, interval_s, now_us, latency_s))) {
        start_anew(self, hand, now_us, in_time);
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
    return displace(self->pose, place_at(&self->translation, &self->translation_change, &at),
                    place_at(&self->rotation, &self->rotation_change, &at));
}

twist_t hand_motion_twist(const hand_motion_t *self, uint32_t now_us, float ahead_s) {
    const schedule_t at = schedule(self, now_us, ahead_s);
    return (twist_t){velocity_at(&self->translation, &self->translation_change, &at),
                     velocity_at(&self->rotation, &self->rotation_change, &at)};
}
