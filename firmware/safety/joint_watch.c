/* Compares the reported motion with the commanded one: see joint_watch.h. */
#include "joint_watch.h"

#include "../maths/float_bits.h"

#define URAD_PER_RAD 1e6f
#define MRADPS_PER_RADPS 1e3f
#define MS_PER_S 1e3f
#define US_PER_MS 1000
#define LAGGING_PER_MRADPS 64 /* unit of `lagging` */
#define ELAPSED_MAX_MS 100    /* keeps the products below 2^31; drives stop by themselves long before */

#define DEVIATION_URAD ((int32_t)(JOINT_WATCH_DEVIATION_RAD * URAD_PER_RAD + 0.5f))
#define REST_URAD ((int32_t)(JOINT_WATCH_REST_RAD * URAD_PER_RAD + 0.5f))

static int32_t urad(float angle_rad) {
    return float_nearest(angle_rad * URAD_PER_RAD);
}

static int32_t smallest(int32_t a, int32_t b, int32_t c) {
    const int32_t ab = a < b ? a : b;
    return ab < c ? ab : c;
}

static int32_t largest(int32_t a, int32_t b, int32_t c) {
    const int32_t ab = a > b ? a : b;
    return ab > c ? ab : c;
}

void joint_watch_init(joint_watch_t *self, const arm_t *arm, uint32_t tick_ms, uint32_t timeout_us) {
    *self = (joint_watch_t){
        .joint_count = arm->joint_count,
        .tick_ms = (int32_t)tick_ms,
        .lag_ms = float_nearest(MS_PER_S * arm->drive_lag_max_s),
        .timeout_us = timeout_us,
    };
    for (int i = 0; i < arm->joint_count; i++) {
        joint_watch_joint_t *joint = &self->joint[i];
        joint->min_urad = urad(arm->joints[i].position_min_rad) - DEVIATION_URAD;
        joint->max_urad = urad(arm->joints[i].position_max_rad) + DEVIATION_URAD;
        joint->commanded_mode = DRIVE_MODE_BRAKE;
    }
}

void joint_watch_report(joint_watch_t *self, int joint, const joint_state_t *state, uint32_t received_us) {
    joint_watch_joint_t *reported = &self->joint[joint];
    const int32_t position_urad = urad(state->position_rad);
    reported->ahead_urad -= position_urad - reported->position_urad;
    reported->position_urad = position_urad;
    reported->error = state->error;
    reported->mode = state->mode;
    reported->received_us = received_us;
    reported->is_reported = true;
    reported->is_new = true;
}

static bool is_in_range(const joint_watch_joint_t *joint) {
    return joint->position_urad >= joint->min_urad && joint->position_urad <= joint->max_urad;
}

/* Updates the time for which the joint has been near a position. */
static bool is_at_rest(joint_watch_joint_t *joint, int32_t elapsed_ms) {
    const int32_t away_urad = joint->position_urad - joint->rest_urad;
    if (!joint->is_reported || away_urad > REST_URAD || away_urad < -REST_URAD) {
        joint->rest_urad = joint->position_urad;
        joint->rest_ms = 0;
    } else if (joint->rest_ms < JOINT_WATCH_REST_MS) {
        joint->rest_ms += elapsed_ms;
    }
    return joint->rest_ms >= JOINT_WATCH_REST_MS;
}

static int32_t lag_urad(const joint_watch_t *self, int32_t lagging) {
    return lagging * self->lag_ms / LAGGING_PER_MRADPS;
}

/* Returns whether the change from the last report to this one is more than the band allows. The times of the reports
 * may differ by a tick more or less than those of the commands, so a joint may also have stood still. */
static bool is_step(const joint_watch_t *self, const joint_watch_joint_t *joint, int32_t next_urad) {
    const int32_t step_urad = joint->position_urad - joint->checked_urad;
    const int32_t fast_urad = joint->fast_urad + next_urad;
    const int32_t slow_urad = joint->fast_urad - lag_urad(self, joint->lagging - joint->was_lagging);
    return step_urad > largest(0, fast_urad, slow_urad) + DEVIATION_URAD ||
           step_urad < smallest(0, fast_urad, slow_urad) - DEVIATION_URAD;
}

/* Returns how far the band is ahead of the position: 0 if it includes the position. */
static int32_t deviation_urad(const joint_watch_t *self, const joint_watch_joint_t *joint, int32_t next_urad) {
    const int32_t slow_urad = joint->ahead_urad - lag_urad(self, joint->lagging);
    const int32_t low_urad = smallest(joint->ahead_urad, joint->ahead_urad + next_urad, slow_urad);
    const int32_t high_urad = largest(joint->ahead_urad, joint->ahead_urad + next_urad, slow_urad);
    return low_urad > 0 ? low_urad : (high_urad < 0 ? high_urad : 0);
}

/* Returns whether a powered joint moves otherwise than commanded. */
static bool deviates(const joint_watch_t *self, joint_watch_joint_t *joint) {
    if (!joint->is_new) {
        return false;
    }
    const int32_t next_urad = joint->velocity_mradps * self->elapsed_ms; /* motion of F since the last command */
    const bool steps = is_step(self, joint, next_urad);
    const int32_t ahead_urad = deviation_urad(self, joint, next_urad);
    if (self->shifts && ahead_urad != 0) { /* 1 mrad/s in every other tick */
        joint->ahead_urad -= ahead_urad > 0 ? self->tick_ms : -self->tick_ms;
    }
    return steps || ahead_urad > DEVIATION_URAD || ahead_urad < -DEVIATION_URAD;
}

static bool is_in_wrong_mode(const joint_watch_t *self, joint_watch_joint_t *joint) {
    if (joint->mode == joint->commanded_mode) {
        joint->wrong_mode_ms = 0;
    } else if (joint->wrong_mode_ms <= JOINT_WATCH_MODE_MS) {
        joint->wrong_mode_ms += self->elapsed_ms;
    }
    return joint->wrong_mode_ms > JOINT_WATCH_MODE_MS;
}

static joint_watch_finding_t check_powered(const joint_watch_t *self, joint_watch_joint_t *joint) {
    /* all are called in each tick, because they keep state */
    const bool moves_otherwise = deviates(self, joint), has_wrong_mode = is_in_wrong_mode(self, joint);
    return !is_in_range(joint) ? JOINT_WATCH_OUT_OF_RANGE
           : moves_otherwise   ? JOINT_WATCH_DEVIATES
           : has_wrong_mode    ? JOINT_WATCH_WRONG_MODE
                               : JOINT_WATCH_OK;
}

static joint_watch_finding_t check_joint(const joint_watch_t *self, joint_watch_joint_t *joint) {
    const joint_watch_finding_t powered = self->is_powered ? check_powered(self, joint) : JOINT_WATCH_OK;
    if (joint->is_new) {
        joint->is_new = false;
        joint->checked_urad = joint->position_urad;
        joint->fast_urad = 0;
        joint->was_lagging = joint->lagging;
    }
    return !joint->is_reported ? JOINT_WATCH_SILENT : joint->error != DRIVE_ERROR_NONE ? JOINT_WATCH_ERROR : powered;
}

/* Counts whole ticks, so that the small irregularities of a loop do not add up. */
static void count_ticks(joint_watch_t *self, uint32_t now_us) {
    const int32_t tick_us = self->tick_ms * US_PER_MS;
    const int32_t since_us = self->is_running ? (int32_t)(now_us - self->counted_us) : tick_us;
    const int32_t ticks = since_us > -tick_us / 2 ? (since_us + tick_us / 2) / tick_us : 0;
    const int32_t elapsed_ms = ticks * self->tick_ms;
    self->elapsed_ms = elapsed_ms < ELAPSED_MAX_MS ? elapsed_ms : ELAPSED_MAX_MS;
    self->counted_us = self->is_running ? self->counted_us + (uint32_t)(ticks * tick_us) : now_us;
    self->is_running = true;
}

joint_watch_result_t joint_watch_check(joint_watch_t *self, uint32_t now_us) {
    count_ticks(self, now_us);
    joint_watch_result_t result = {.finding = JOINT_WATCH_OK, .in_range = true, .at_rest = true};
    for (int i = 0; i < self->joint_count; i++) {
        joint_watch_joint_t *joint = &self->joint[i];
        joint->is_reported = joint->is_reported && now_us - joint->received_us <= self->timeout_us;
        const joint_watch_finding_t finding = check_joint(self, joint);
        if (finding != JOINT_WATCH_OK && (result.finding == JOINT_WATCH_OK || finding < result.finding)) {
            result.finding = finding;
        }
        result.in_range = result.in_range && is_in_range(joint);
        result.at_rest = is_at_rest(joint, self->elapsed_ms) && result.at_rest;
    }
    self->shifts = !self->shifts;
    return result;
}

/* The last command has been in force since the last check. */
static void advance(const joint_watch_t *self, joint_watch_joint_t *joint) {
    const int32_t moved_urad = joint->velocity_mradps * self->elapsed_ms;
    joint->ahead_urad += moved_urad;
    joint->fast_urad += moved_urad;
    joint->lagging += (joint->velocity_mradps * LAGGING_PER_MRADPS - joint->lagging) * self->elapsed_ms /
                      (self->lag_ms + self->elapsed_ms);
}

/* A joint without power may be moved by hand, so the comparison starts afresh. */
static void forget_motion(joint_watch_joint_t *joint) {
    joint->ahead_urad = 0;
    joint->lagging = 0;
    joint->was_lagging = 0;
    joint->fast_urad = 0;
    joint->wrong_mode_ms = 0;
}

void joint_watch_command(joint_watch_t *self, const joint_cmd_t *command, bool is_powered) {
    for (int i = 0; i < self->joint_count; i++) {
        joint_watch_joint_t *joint = &self->joint[i];
        if (self->is_powered && is_powered) {
            advance(self, joint);
        } else {
            forget_motion(joint);
        }
        joint->velocity_mradps = float_nearest(command->velocity_radps[i] * MRADPS_PER_RADPS);
        joint->commanded_mode = command->mode[i];
    }
    self->is_powered = is_powered;
}
