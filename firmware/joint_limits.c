#include "joint_limits.h"

#include <float.h>

#include "can_protocol.h"
#include "comanip_schema.h"
#include "float_bits.h"

#define VELOCITY_RESOLUTION_RADPS COMANIP_JOINT_CMD_VELOCITY_0_RADPS_RESOLUTION
#define VELOCITY_STEPS_PER_RADPS COMANIP_JOINT_CMD_VELOCITY_0_RADPS_PER_UNIT
#define POSITION_RESOLUTION_RAD COMANIP_JOINT_CMD_POSITION_0_RAD_RESOLUTION

/* A quotient that is a whole number but for float32's rounding counts as that number. */
#define ROUNDING_STEPS 1e-3f

static float smaller(float a, float b) {
    return a < b ? a : b;
}

static float clamp(float x, float low, float high) {
    return x < low ? low : (x > high ? high : x);
}

/* The largest speed, up to speed_max_radps, from which a joint still stops within the distance. Until a command acts, the joint travels on
 * with the commands under way, which while it brakes are the faster the older they are: (v + a delay)^2 / (2 a) = distance. */
static float stopping_speed(const joint_limits_plan_t *plan, float distance_rad, float speed_max_radps) {
    if (distance_rad <= 0.0f) {
        return 0.0f;
    }
    const float squared = 2.0f * plan->braking_radps2 * distance_rad;
    const float fastest_radps = speed_max_radps + plan->coasting_radps;
    if (fastest_radps * fastest_radps <= squared) { /* as a rule: without a square root */
        return speed_max_radps;
    }
    const float speed = __builtin_sqrtf(squared) - plan->coasting_radps;
    return speed > 0.0f ? smaller(speed, speed_max_radps) : 0.0f;
}

/* What the law asks is K times the way to go, so that the speed falls as exp(-K t): more deceleration than there is,
 * when the speed is above a / K, the linear speed. Above it the speed is held to the one that stops on the way to go; below, the
 * law's own. */
static float approach_speed(float wanted_speed_radps, float linear_radps) {
    if (wanted_speed_radps <= linear_radps) {
        return wanted_speed_radps;
    }
    /* tangent to the line u = K x at u = a / K, then v^2 = 2 a (x - a / (2 K^2)) */
    return __builtin_sqrtf(linear_radps * (2.0f * wanted_speed_radps - linear_radps));
}

/* The speed that is not above this one, in steps of the bus's resolution, which every command is a whole number of. */
static int32_t steps_below(float speed_radps) {
    return (int32_t)(speed_radps * VELOCITY_STEPS_PER_RADPS + ROUNDING_STEPS);
}

static int32_t clamp_steps(int32_t x, int32_t low, int32_t high) {
    return x < low ? low : (x > high ? high : x);
}

void joint_limits_prepare(joint_limits_config_t *config) {
    const int32_t change_max_steps = steps_below(config->acceleration_max_radps2 * config->tick_s);
    const float change_max_radps = (float)change_max_steps * VELOCITY_RESOLUTION_RADPS;
    const float braking_radps2 = JOINT_LIMITS_BRAKING_RESERVE * change_max_radps / config->tick_s;
    const float delay_s = config->command_delay_s + config->tick_s; /* a command stays for a tick */
    config->plan = (joint_limits_plan_t){
        .change_max_steps = change_max_steps,
        .braking_radps2 = braking_radps2,
        .linear_radps = config->approach_gain_per_s > 0.0f ? braking_radps2 / config->approach_gain_per_s : FLT_MAX,
        .coasting_radps = braking_radps2 * delay_s,
        .near_end_rad = JOINT_LIMITS_AT_LIMIT_RAD + 0.5f * braking_radps2 * delay_s * delay_s,
    };
}

void joint_limits_init(joint_limits_t *self) {
    *self = (joint_limits_t){0};
}

/* How much of the error's velocities is asked for, so that each joint stops on what is left of its way. */
static float approach_scale(const joint_limits_plan_t *plan, int joint_count, const float error_radps[]) {
    float scale = 1.0f; /* of all joints alike */
    for (int i = 0; i < joint_count; i++) {
        const float speed = __builtin_fabsf(error_radps[i]);
        const float allowed_radps = approach_speed(speed, plan->linear_radps);
        if (speed > allowed_radps) {
            scale = smaller(scale, allowed_radps / speed);
        }
    }
    return scale;
}

bool joint_limits_apply(joint_limits_t *self, const arm_t *arm, const joint_limits_config_t *config, const float measured_rad[],
                        const float error_radps[], const float feedforward_radps[]) {
    const joint_limits_plan_t *plan = &config->plan;
    const float error_scale = approach_scale(plan, arm->joint_count, error_radps);
    float wanted_radps[ARM_MAX_JOINTS], speed_max_radps[ARM_MAX_JOINTS];
    bool finite = true;
    float scale = 1.0f; /* of all joints alike */
    for (int i = 0; i < arm->joint_count; i++) {
        wanted_radps[i] = error_scale * error_radps[i] + feedforward_radps[i];
        speed_max_radps[i] = config->speed_fraction * arm->joints[i].velocity_max_radps;
        finite = finite && float_is_finite(measured_rad[i]) && float_is_finite(wanted_radps[i]);
        const float speed = __builtin_fabsf(wanted_radps[i]);
        if (speed > speed_max_radps[i]) {
            scale = smaller(scale, speed_max_radps[i] / speed);
        }
    }
    for (int i = 0; i < arm->joint_count; i++) {
        const arm_joint_t *joint = &arm->joints[i];
        const int32_t last_steps = self->velocity_steps[i];
        int32_t velocity_steps = 0;
        if (finite) {
            velocity_steps = float_nearest(scale * wanted_radps[i] * VELOCITY_STEPS_PER_RADPS);
            const bool upwards = velocity_steps > 0;
            const float way_rad =
                upwards ? joint->position_max_rad - measured_rad[i] : measured_rad[i] - joint->position_min_rad;
            const int32_t allowed_steps = steps_below(stopping_speed(plan, way_rad, speed_max_radps[i]));
            velocity_steps = clamp_steps(velocity_steps, upwards ? 0 : -allowed_steps, upwards ? allowed_steps : 0);
        }
        velocity_steps = clamp_steps(velocity_steps, last_steps - plan->change_max_steps, last_steps + plan->change_max_steps);
        self->velocity_steps[i] = velocity_steps;
        self->velocity_radps[i] = (float)velocity_steps * VELOCITY_RESOLUTION_RADPS;
        if (finite) { /* not quite to the ends, so that the rounded reference on the bus is within them */
            self->position_rad[i] = clamp(measured_rad[i] + self->velocity_radps[i] * config->tick_s,
                                          joint->position_min_rad + POSITION_RESOLUTION_RAD,
                                          joint->position_max_rad - POSITION_RESOLUTION_RAD);
        }
    }
    return finite;
}

joint_ends_t joint_limits_ends(const arm_t *arm, const joint_limits_config_t *config, const float measured_rad[]) {
    const float near_end_rad = config->plan.near_end_rad;
    unsigned lower = 0, upper = 0;
    for (int i = 0; i < arm->joint_count; i++) {
        const arm_joint_t *joint = &arm->joints[i];
        const unsigned bit = 1u << i;
        lower |= measured_rad[i] - joint->position_min_rad < near_end_rad ? bit : 0u;
        upper |= joint->position_max_rad - measured_rad[i] < near_end_rad ? bit : 0u;
    }
    return (joint_ends_t){(uint8_t)lower, (uint8_t)upper};
}

bool joint_limits_at_rest(const joint_limits_t *self, const arm_t *arm) {
    for (int i = 0; i < arm->joint_count; i++) {
        if (self->velocity_steps[i] != 0) {
            return false;
        }
    }
    return true;
}
