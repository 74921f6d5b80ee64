/* Searches for another posture and moves the arm to it: see posture_change.h. */
#include "posture_change.h"

#include <float.h>
#include <string.h>

#define STILL_M 5e-3f    /* a watched target that moves less than this is at rest */
#define PROGRESS_M 1e-3f /* if the distance from the target changes by more than this, the end effector is not stuck */

#define SEED_JOINTS 4 /* joint i starts on the same side of its range as joint i % SEED_JOINTS */
#define SEEDS (1 << SEED_JOINTS)
#define STEPS 40 /* number of steps per candidate */
#define MET_M 5e-4f
#define ORIENTATION_SHARE 0.1f /* factor on the orientation weight in a search */

#define ARRIVED_RAD 1e-3f
#define STANDS_RAD 5e-3f /* inverse kinematics resumes if a joint is pushed farther than this from the posture, */
#define STANDS_M 1e-3f   /* or if the target has moved farther than this since the search began */

static bool is_away(const posture_change_t *self, const position_priority_request_t *request, float distance_m) {
    const vector3_t way_m = vector3_add(request->target->translation_m, vector3_scale(self->target_m, -1.0f));
    return vector3_dot(way_m, way_m) > distance_m * distance_m;
}

static float longest_way(const float from_rad[], const float to_rad[], int joint_count) {
    float longest_rad = 0.0f;
    for (int i = 0; i < joint_count; i++) {
        const float way_rad = __builtin_fabsf(to_rad[i] - from_rad[i]);
        longest_rad = way_rad > longest_rad ? way_rad : longest_rad;
    }
    return longest_rad;
}

static void restart_watch(posture_change_t *self, const position_priority_request_t *request, float distance_m) {
    self->phase = POSTURE_WATCHED;
    self->target_m = request->target->translation_m;
    self->distance_m = distance_m;
    self->still_s = 0.0f;
}

/* ---- search */

static void begin_candidate(posture_change_t *self, const arm_t *arm, uint8_t seed) {
    self->seed = seed;
    self->steps = 0;
    for (int i = 0; i < arm->joint_count; i++) {
        const arm_joint_t *joint = &arm->joints[i];
        const float share = (seed >> i % SEED_JOINTS & 1) != 0 ? 0.75f : 0.25f;
        self->candidate_rad[i] = joint->position_min_rad + share * (joint->position_max_rad - joint->position_min_rad);
    }
}

static void begin_search(posture_change_t *self, const arm_t *arm, const position_priority_request_t *request) {
    self->phase = POSTURE_SEARCHED;
    self->target_m = request->target->translation_m;
    self->way_rad = FLT_MAX;
    begin_candidate(self, arm, 0);
}

/* Moves the candidate by one step: the velocities of position_priority() for K = 1/s, applied for one second. Each
 * joint keeps away from its limits, by slightly less than the distance at which it is treated as being at a limit.
 * Returns the end effector's distance from the target before the step. */
static float improve(posture_change_t *self, const posture_change_config_t *config, const pose_t *target) {
    static const twist_t none = {{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}};
    const arm_t *arm = config->ik->arm;
    const position_priority_config_t law = {
        .gain_per_s = 1.0f,
        .orientation_weight_m2 = ORIENTATION_SHARE * config->law->orientation_weight_m2,
    };
    const position_priority_request_t request = {
        .position_rad = self->candidate_rad,
        .target = target,
        .motion = &none,
        .at_limit = joints_at_limit_find(arm, config->limits->at_limit_rad, self->candidate_rad),
    };
    float step_rad[ARM_MAX_JOINTS], motion[ARM_MAX_JOINTS];
    const float distance_m = arm_ik_position_priority(config->ik, &law, &request, step_rad, motion);
    for (int i = 0; i < arm->joint_count; i++) {
        const float inside_rad = 0.99f * config->limits->at_limit_rad[i];
        const float low_rad = arm->joints[i].position_min_rad + inside_rad;
        const float high_rad = arm->joints[i].position_max_rad - inside_rad;
        const float to_rad = self->candidate_rad[i] + step_rad[i];
        self->candidate_rad[i] = to_rad < low_rad ? low_rad : (to_rad > high_rad ? high_rad : to_rad);
    }
    self->steps++;
    return distance_m;
}

static void keep_nearest(posture_change_t *self, const float position_rad[], int joint_count) {
    const float way_rad = longest_way(position_rad, self->candidate_rad, joint_count);
    if (way_rad < self->way_rad) {
        self->way_rad = way_rad;
        memcpy(self->nearest_rad, self->candidate_rad, sizeof self->nearest_rad);
    }
}

/* Makes one step of the search. After all seeds have been tried, the nearest candidate takes further steps, so that its
 * orientation becomes nearly optimal as well. */
static void search(posture_change_t *self, const posture_change_config_t *config,
                   const position_priority_request_t *request) {
    const float distance_m = improve(self, config, request->target);
    const bool is_met = distance_m < MET_M;
    if (self->seed == SEEDS) {
        if (self->steps == STEPS) {
            self->phase = is_met ? POSTURE_CHANGING : POSTURE_LEFT;
        }
        return;
    }
    if (is_met) {
        keep_nearest(self, request->position_rad, config->ik->arm->joint_count);
    } else if (self->steps < STEPS) {
        return;
    }
    begin_candidate(self, config->ik->arm, (uint8_t)(self->seed + 1));
    if (self->seed == SEEDS) {
        memcpy(self->candidate_rad, self->nearest_rad, sizeof self->candidate_rad);
        self->phase = self->way_rad == FLT_MAX ? POSTURE_LEFT : POSTURE_SEARCHED;
    }
}

/* ---- change */

static float hand_speed(const arm_t *arm, const float position_rad[], const float velocity_radps[]) {
    arm_jacobian_t jacobian;
    arm_jacobian(arm, position_rad, &jacobian);
    vector3_t hand_mps = {0.0f, 0.0f, 0.0f};
    for (int i = 0; i < arm->joint_count; i++) {
        hand_mps = vector3_add(hand_mps, vector3_scale(jacobian.linear_m[i], velocity_radps[i]));
    }
    return __builtin_sqrtf(vector3_dot(hand_mps, hand_mps));
}

/* Sets the velocities of all joints, scaled by the same factor, so the arm moves in a straight line in joint space.
 * Since both ends of that line are within the joint limits, so is the whole line. */
static void move(const posture_change_t *self, const posture_change_config_t *config, const float position_rad[],
                 float velocity_radps[]) {
    const arm_t *arm = config->ik->arm;
    const float fraction = config->limits->speed_fraction;
    const float share = fraction < POSTURE_CHANGE_JOINT_SHARE ? fraction : POSTURE_CHANGE_JOINT_SHARE;
    for (int i = 0; i < arm->joint_count; i++) {
        velocity_radps[i] = config->law->gain_per_s * (self->candidate_rad[i] - position_rad[i]);
    }
    const float hand_mps = hand_speed(arm, position_rad, velocity_radps);
    float scale = hand_mps > POSTURE_CHANGE_HAND_MPS ? POSTURE_CHANGE_HAND_MPS / hand_mps : 1.0f;
    for (int i = 0; i < arm->joint_count; i++) {
        const float speed_radps = __builtin_fabsf(velocity_radps[i]);
        const float allowed_radps = share * arm->joints[i].velocity_max_radps;
        if (scale * speed_radps > allowed_radps) {
            scale = allowed_radps / speed_radps;
        }
    }
    for (int i = 0; i < arm->joint_count; i++) {
        velocity_radps[i] *= scale;
    }
}

/* ---- interface */

void posture_change_init(posture_change_t *self) {
    memset(self, 0, sizeof *self);
}

bool posture_change_step(posture_change_t *self, const posture_change_config_t *config,
                         const position_priority_request_t *request, float feedback_radps[]) {
    const int joint_count = config->ik->arm->joint_count;
    if (self->phase != POSTURE_WATCHED && is_away(self, request, POSTURE_CHANGE_AWAY_M)) {
        restart_watch(self, request, 0.0f);
    }
    const float way_rad = longest_way(request->position_rad, self->candidate_rad, joint_count);
    if (self->phase == POSTURE_CHANGING && way_rad < ARRIVED_RAD) {
        self->phase = POSTURE_CHANGED;
    }
    if (self->phase == POSTURE_CHANGED && (way_rad > STANDS_RAD || is_away(self, request, STANDS_M))) {
        self->phase = POSTURE_LEFT;
    }
    if (self->phase == POSTURE_WATCHED || self->phase == POSTURE_LEFT) {
        return false;
    }
    memset(feedback_radps, 0, (size_t)joint_count * sizeof *feedback_radps);
    if (self->phase == POSTURE_SEARCHED) {
        search(self, config, request);
    } else if (self->phase == POSTURE_CHANGING) {
        move(self, config, request->position_rad, feedback_radps);
    }
    return true;
}

void posture_change_watch(posture_change_t *self, const posture_change_config_t *config,
                          const position_priority_request_t *request, float distance_m) {
    if (self->phase != POSTURE_WATCHED) {
        return;
    }
    const bool is_stuck = distance_m > POSTURE_CHANGE_ERROR_M && joints_at_limit_any(request->at_limit);
    if (!is_stuck || is_away(self, request, STILL_M) || __builtin_fabsf(distance_m - self->distance_m) > PROGRESS_M) {
        restart_watch(self, request, distance_m);
        return;
    }
    self->still_s += config->limits->tick_s;
    if (self->still_s >= POSTURE_CHANGE_STILL_S) {
        begin_search(self, config->ik->arm, request);
    }
}

bool posture_change_is_moving(const posture_change_t *self) {
    return self->phase == POSTURE_CHANGING;
}
