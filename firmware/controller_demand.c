/* Computes the joint velocities that Algorithm 1 and inverse kinematics demand: see controller_demand.h. */
#include "controller_demand.h"

#include <string.h>

/* While the end effector catches up with a target that it has lost, the joints may use only the share CATCHING_UP_SPEED
 * of their speed limits, until the end effector is within CAUGHT_UP_M of the target. */
#define CATCHING_UP_SPEED 0.55f
#define CAUGHT_UP_M 1e-3f

/* Inline, to save a function call in every tick. */
static inline float task_blend(const controller_t *self) {
    if (self->blend_elapsed_s >= self->blend_s) {
        return 1.0f;
    }
    float s = self->blend_elapsed_s / self->blend_s;
    return s * s * s * (10.0f + s * (6.0f * s - 15.0f));
}

float controller_task_blend(const controller_t *self) {
    return task_blend(self);
}

void controller_zero_feedback(controller_t *self) {
    memset(self->feedback_radps, 0, sizeof self->feedback_radps);
}

void controller_zero_demand(controller_t *self) {
    controller_zero_feedback(self);
    memset(self->feedforward_radps, 0, sizeof self->feedforward_radps);
    self->catching_up = false;
}

/* Scales all joints by the same factor, so that the end effector keeps its direction of motion. */
static void limit_catching_up(controller_t *self) {
    const float part = CATCHING_UP_SPEED * self->parameters.value[PARAMETER_SPEED_FRACTION];
    float scale = 1.0f;
    for (int i = 0; i < self->arm->joint_count; i++) {
        const float speed_radps = __builtin_fabsf(self->feedback_radps[i] + self->feedforward_radps[i]);
        const float allowed_radps = part * self->arm->joints[i].velocity_max_radps;
        if (scale * speed_radps > allowed_radps) {
            scale = allowed_radps / speed_radps;
        }
    }
    for (int i = 0; i < self->arm->joint_count; i++) {
        self->feedback_radps[i] *= scale;
        self->feedforward_radps[i] *= scale;
    }
}

/* Returns the twist of the person's hand, in the tracker frame, at the time when this tick's command takes effect.
 * Takes into account how far the lever from the marker to the hand will have rotated by then. */
static twist_t hand_twist(const controller_t *self, uint32_t now_us) {
    const float ahead_s = self->parameters.value[PARAMETER_COMMAND_DELAY_S];
    const twist_t marker = hand_motion_twist(&self->marker_motion, now_us, ahead_s);
    if (self->marker_is_hand) {
        return marker;
    }
    const vector3_t turning_mps = vector3_cross(marker.angular_velocity_radps, self->lever_m);
    const float turning_s = controller_tick_s(self) + ahead_s;
    const vector3_t lever_m = vector3_add(self->lever_m, vector3_scale(turning_mps, turning_s));
    return (twist_t){vector3_add(marker.velocity_mps, vector3_cross(marker.angular_velocity_radps, lever_m)),
                     marker.angular_velocity_radps};
}

/* With prediction, the target's motion is fed forward, and position has priority over orientation. */
static void follow_predicted_target(controller_t *self, uint32_t now_us, joints_at_limit_t at_limit) {
    const twist_t hand = hand_twist(self, now_us);
    const twist_t motion = cooperation_target_motion(&self->cooperation, &hand);
    const position_priority_request_t request = {
        .position_rad = self->measured_rad,
        .target = &self->cooperation.target,
        .motion = &motion,
        .at_limit = at_limit,
    };
    const posture_change_config_t config = {self->ik, &self->position_priority_config, &self->joint_limits_config};
    const bool may_change_posture = self->changes_posture && !self->cooperation.latched;
    if (may_change_posture && posture_change_step(&self->posture_change, &config, &request, self->feedback_radps)) {
        memset(self->feedforward_radps, 0, sizeof self->feedforward_radps);
        return;
    }
    const float distance_m = arm_ik_position_priority(self->ik, &self->position_priority_config, &request,
                                                      self->feedback_radps, self->feedforward_radps);
    if (may_change_posture) {
        posture_change_watch(&self->posture_change, &config, &request, distance_m);
    }
    self->catching_up = distance_m > POSITION_PRIORITY_ERROR_MAX_M || (self->catching_up && distance_m > CAUGHT_UP_M);
    if (self->catching_up) {
        limit_catching_up(self);
    }
}

/* Without prediction, the paper's differential inverse kinematics is used. */
static void follow_target(controller_t *self, joints_at_limit_t at_limit) {
    const differential_ik_request_t request = {
        .position_rad = self->measured_rad,
        .target = &self->cooperation.target,
        .at_limit = at_limit,
    };
    arm_ik_differential(self->ik, &self->differential_ik_config, &request, self->feedback_radps);
}

/* A tick in which the operator changes the cooperation reuses the previous demand, since handling the change and
 * computing a new demand together would overrun the tick. Two successive ticks never both reuse it, so that repeated
 * commands cannot starve control. */
void controller_compute_demand(controller_t *self, uint32_t now_us) {
    const bool was_deferred = self->demand_deferred;
    self->demand_deferred = false;
    if (self->supervisor.mode != MODE_COOPERATING || self->cooperation_changed) {
        posture_change_init(&self->posture_change);
    }
    if (self->supervisor.mode != MODE_COOPERATING) {
        controller_zero_demand(self);
        return;
    }
    if (self->cooperation_changed && !was_deferred) {
        self->demand_deferred = true;
        return;
    }
    cooperation_update(&self->cooperation, &self->hand, task_blend(self));
    self->blend_elapsed_s += self->blend_elapsed_s < self->blend_s ? controller_tick_s(self) : 0.0f;
    const joints_at_limit_t at_limit =
        joints_at_limit_find(self->arm, self->joint_limits_config.at_limit_rad, self->measured_rad);
    if (self->predicts) {
        follow_predicted_target(self, now_us, at_limit);
    } else {
        follow_target(self, at_limit);
    }
}
