/* Limits the joint commands: see joint_limits.h. */
#include "joint_limits.h"

#include <float.h>

#include "../maths/float_bits.h"
#include "../protocol/can_protocol.h"
#include "comanip_schema.h"

#define VELOCITY_RESOLUTION_RADPS COMANIP_JOINT_CMD_VELOCITY_0_RADPS_RESOLUTION
#define VELOCITY_STEPS_PER_RADPS COMANIP_JOINT_CMD_VELOCITY_0_RADPS_PER_UNIT
#define POSITION_RESOLUTION_RAD COMANIP_JOINT_CMD_POSITION_0_RAD_RESOLUTION

/* A quotient that is an integer except for float32's rounding error is treated as that integer. */
#define ROUNDING_STEPS 1e-3f

/* Upper limit of a^2 / j, where a is the deceleration used for planning and j the jerk limit. If j is small, braking is
 * therefore planned with less than the acceleration limit. With a larger upper limit, the arm would overshoot on
 * arrival. */
#define RAMP_SPEED_MAX_RADPS 0.1f

static float clamp(float x, float low, float high) {
    return x < low ? low : (x > high ? high : x);
}

/* Returns the largest speed, up to the joint's speed limit, from which a joint stops within the distance if its
 * deceleration grows from 0: v^2 / (2 a) + v a / (2 j) = distance. Until a new command takes effect, a braking joint
 * follows earlier commands, which demand a higher speed; coasting_radps makes allowance for this delay. */
static float stopping_speed(const joint_limits_plan_t *plan, float distance_rad) {
    if (!float_is_below(0.0f, distance_rad)) {
        return 0.0f;
    }
    const float squared = plan->twice_braking_radps2 * distance_rad + plan->ramp_square;
    if (!float_is_below(squared, plan->fastest_square)) { /* the usual case, without a square root */
        return plan->speed_max_radps;
    }
    const float speed = __builtin_sqrtf(squared) - plan->coasting_radps;
    return float_is_below(0.0f, speed) ? float_smaller(speed, plan->speed_max_radps) : 0.0f;
}

/* The demanded speed is K times the remaining distance, so it decays as exp(-K t). Above the speed linear_radps = a /
 * K, this decay would require more deceleration than a, so the speed is limited to the one from which the joint stops
 * within the remaining distance. Below a / K, the demanded speed is returned. */
static float approach_speed(float demanded_radps, float linear_radps) {
    if (!float_is_below(linear_radps, demanded_radps)) {
        return demanded_radps;
    }
    /* v^2 = 2 a (x - a / (2 K^2)), which is tangent to the line u = K x at u = a / K */
    return __builtin_sqrtf(linear_radps * (2.0f * demanded_radps - linear_radps));
}

/* Returns the speed in steps of the bus's resolution, rounded down. */
static int32_t steps_below(float speed_radps) {
    return (int32_t)(speed_radps * VELOCITY_STEPS_PER_RADPS + ROUNDING_STEPS);
}

static int32_t clamp_steps(int32_t x, int32_t low, int32_t high) {
    return x < low ? low : (x > high ? high : x);
}

/* Returns the change of velocity in this tick, towards a velocity that is `way` >= 0 steps higher. last: the change in
 * the last tick.
 *
 * The result is the largest change that does not overshoot. Let J be jerk_steps. The sum of a change x and the
 * following changes, each smaller by J, is (k + 1) x - T(k), where k = floor(x / J) is the number of ticks that follow
 * and T(k) = J k (k + 1) / 2. Since x is within J of the last change, its k is within 1 of that of the last change. If
 * even last - J overshoots, last - J is returned. */
static int32_t next_change(const joint_limits_plan_t *plan, int32_t way, int32_t last) {
    const int32_t jerk = plan->jerk_steps;
    int32_t k = last > 0 ? last / jerk : 0;
    int32_t sum = jerk * k * (k + 1) / 2;
    if (way < sum) {
        sum -= jerk * k;
        k--;
    } else if (way >= sum + jerk * (k + 1)) {
        k++;
        sum += jerk * k;
    }
    const int32_t change = clamp_steps((way + sum) / (k + 1), last - jerk, last + jerk);
    return clamp_steps(change, -plan->change_max_steps, plan->change_max_steps);
}

static joint_limits_plan_t plan_joint(const joint_limits_config_t *config, const arm_joint_t *joint) {
    const float tick_s = config->tick_s;
    const int32_t change_max_steps = steps_below(config->acceleration_max_radps2 * tick_s);
    const int32_t jerk_steps = steps_below(joint->jerk_max_radps3 * tick_s * tick_s);
    const float acceleration_radps2 = (float)change_max_steps * VELOCITY_RESOLUTION_RADPS / tick_s;
    const float jerk_radps3 = (float)jerk_steps * VELOCITY_RESOLUTION_RADPS / (tick_s * tick_s);
    const float braking_radps2 = float_smaller(JOINT_LIMITS_BRAKING_RESERVE * acceleration_radps2,
                                               __builtin_sqrtf(RAMP_SPEED_MAX_RADPS * jerk_radps3));
    const float ramp_s = braking_radps2 / jerk_radps3;
    const float ramp_radps = 0.5f * braking_radps2 * ramp_s;
    /* Besides the growth of the deceleration, this allows for the command delay, for the tick during which a command is
     * held, and for the time by which the velocity lags behind the stopping speed, half the duration of a ramp. */
    const float coasting_radps = ramp_radps + braking_radps2 * (config->command_delay_s + tick_s + 0.5f * ramp_s);
    const float speed_max_radps = config->speed_fraction * joint->velocity_max_radps;
    return (joint_limits_plan_t){
        .change_max_steps = change_max_steps,
        .jerk_steps = jerk_steps,
        .ramp_ticks_per_step = 1.0f / (float)jerk_steps,
        .speed_max_radps = speed_max_radps,
        .braking_radps2 = braking_radps2,
        .linear_radps = config->approach_gain_per_s > 0.0f ? braking_radps2 / config->approach_gain_per_s : FLT_MAX,
        .twice_braking_radps2 = 2.0f * braking_radps2,
        .ramp_square = ramp_radps * ramp_radps,
        .fastest_square = (speed_max_radps + coasting_radps) * (speed_max_radps + coasting_radps),
        .coasting_radps = coasting_radps,
        .reference_min_rad = joint->position_min_rad + POSITION_RESOLUTION_RAD,
        .reference_max_rad = joint->position_max_rad - POSITION_RESOLUTION_RAD,
    };
}

void joint_limits_prepare(joint_limits_config_t *config, const arm_t *arm) {
    for (int i = 0; i < arm->joint_count; i++) {
        joint_limits_plan_t *plan = &config->plan[i];
        *plan = plan_joint(config, &arm->joints[i]);
        config->at_limit_rad[i] =
            JOINT_LIMITS_AT_LIMIT_RAD +
            0.5f * (plan->coasting_radps * plan->coasting_radps - plan->ramp_square) / plan->braking_radps2;
    }
}

void joint_limits_init(joint_limits_t *self) {
    *self = (joint_limits_t){0};
}

/* Returns the factor by which the feedback velocities are scaled, so that each joint can stop within its remaining
 * distance. */
static float approach_scale(const joint_limits_plan_t plan[], int joint_count, const float feedback_radps[]) {
    float scale = 1.0f; /* common to all joints */
    for (int i = 0; i < joint_count; i++) {
        const float speed = __builtin_fabsf(feedback_radps[i]);
        const float allowed_radps = approach_speed(speed, plan[i].linear_radps);
        if (float_is_below(allowed_radps, speed)) {
            scale = float_smaller(scale, allowed_radps / speed);
        }
    }
    return scale;
}

/* Returns the greatest distance that a joint moves while its acceleration decreases to 0. change_steps: the
 * acceleration, as the increase of the speed per tick. */
static float ramp_way(const joint_limits_config_t *config, const joint_limits_plan_t *plan, float speed_radps,
                      int32_t change_steps) {
    const float change = (float)change_steps;
    const float ticks = change * plan->ramp_ticks_per_step;
    return config->tick_s * ticks * (speed_radps + 0.5f * VELOCITY_RESOLUTION_RADPS * change * ticks);
}

bool joint_limits_apply(joint_limits_t *self, const arm_t *arm, const joint_limits_config_t *config,
                        const float measured_rad[], const float feedback_radps[], const float feedforward_radps[]) {
    const float error_scale = approach_scale(config->plan, arm->joint_count, feedback_radps);
    float demand_radps[ARM_MAX_JOINTS];
    bool finite = true;
    float scale = 1.0f; /* common to all joints */
    for (int i = 0; i < arm->joint_count; i++) {
        demand_radps[i] = error_scale * feedback_radps[i] + feedforward_radps[i];
        finite = finite && float_is_finite(measured_rad[i]) && float_is_finite(demand_radps[i]);
        const float speed = __builtin_fabsf(demand_radps[i]);
        if (float_is_below(config->plan[i].speed_max_radps, speed)) {
            scale = float_smaller(scale, config->plan[i].speed_max_radps / speed);
        }
    }
    for (int i = 0; i < arm->joint_count; i++) {
        const arm_joint_t *joint = &arm->joints[i];
        const joint_limits_plan_t *plan = &config->plan[i];
        const int32_t last_steps = self->change_steps[i];
        int32_t velocity_steps = 0;
        if (finite) {
            velocity_steps = float_nearest(scale * demand_radps[i] * VELOCITY_STEPS_PER_RADPS);
            const bool upwards = velocity_steps > 0;
            float way_rad =
                upwards ? joint->position_max_rad - measured_rad[i] : measured_rad[i] - joint->position_min_rad;
            const int32_t growth = upwards ? last_steps : -last_steps;
            if (growth > 0) {
                way_rad -= ramp_way(config, plan, __builtin_fabsf(self->velocity_radps[i]), growth);
            }
            const int32_t allowed_steps = steps_below(stopping_speed(plan, way_rad));
            velocity_steps = clamp_steps(velocity_steps, upwards ? 0 : -allowed_steps, upwards ? allowed_steps : 0);
        }
        const int32_t way_steps = velocity_steps - self->velocity_steps[i];
        self->change_steps[i] =
            way_steps < 0 ? -next_change(plan, -way_steps, -last_steps) : next_change(plan, way_steps, last_steps);
        self->velocity_steps[i] += self->change_steps[i];
        self->velocity_radps[i] = (float)self->velocity_steps[i] * VELOCITY_RESOLUTION_RADPS;
        if (finite) {
            const float reference_rad = measured_rad[i] + self->velocity_radps[i] * config->tick_s;
            self->position_rad[i] = clamp(reference_rad, plan->reference_min_rad, plan->reference_max_rad);
        }
    }
    return finite;
}

bool joint_limits_at_rest(const joint_limits_t *self, const arm_t *arm) {
    for (int i = 0; i < arm->joint_count; i++) {
        if (self->velocity_steps[i] != 0 || self->change_steps[i] != 0) {
            return false;
        }
    }
    return true;
}
