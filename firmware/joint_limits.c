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

/* Largest speed from which a joint still stops within the distance. Until a command acts, the joint travels on with the
 * commands under way, which while it brakes are the faster the older they are: (v + a delay)^2 / (2 a) = distance. */
static float stopping_speed(float distance_rad, float acceleration_radps2, float delay_s) {
    if (distance_rad <= 0.0f) {
        return 0.0f;
    }
    float speed = __builtin_sqrtf(2.0f * acceleration_radps2 * distance_rad) - acceleration_radps2 * delay_s;
    return speed > 0.0f ? speed : 0.0f;
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

/* In steps of the bus's resolution, which every command is a whole number of. */
static int32_t nearest_step(float velocity_radps) {
    float steps = velocity_radps * VELOCITY_STEPS_PER_RADPS;
    return (int32_t)(steps + __builtin_copysignf(0.5f, steps));
}

/* The speed that is not above this one. */
static int32_t steps_below(float speed_radps) {
    return (int32_t)(speed_radps * VELOCITY_STEPS_PER_RADPS + ROUNDING_STEPS);
}

static int32_t clamp_steps(int32_t x, int32_t low, int32_t high) {
    return x < low ? low : (x > high ? high : x);
}

/* What a tick can change. */
static int32_t change_max_steps(const joint_limits_config_t *config, float tick_s) {
    return steps_below(config->acceleration_max_radps2 * tick_s);
}

/* The deceleration to plan with. */
static float braking(const joint_limits_config_t *config, float tick_s) {
    return JOINT_LIMITS_BRAKING_RESERVE * (float)change_max_steps(config, tick_s) * VELOCITY_RESOLUTION_RADPS / tick_s;
}

void joint_limits_init(joint_limits_t *self) {
    *self = (joint_limits_t){0};
}

bool joint_limits_apply(joint_limits_t *self, const arm_t *arm, const joint_limits_config_t *config, float tick_s,
                        const float measured_rad[], const float wanted_radps[]) {
    const int32_t change_steps = change_max_steps(config, tick_s);
    const float braking_radps2 = braking(config, tick_s);
    const float linear_radps = config->approach_gain_per_s > 0.0f ? braking_radps2 / config->approach_gain_per_s : FLT_MAX;
    const float delay_s = config->command_delay_s + tick_s; /* a command stays for a tick */
    bool finite = true;
    float scale = 1.0f; /* of all joints alike */
    for (int i = 0; i < arm->joint_count; i++) {
        finite = finite && float_is_finite(measured_rad[i]) && float_is_finite(wanted_radps[i]);
        float speed = __builtin_fabsf(wanted_radps[i]);
        float allowed_radps = smaller(config->speed_fraction * arm->joints[i].velocity_max_radps,
                                      approach_speed(speed, linear_radps));
        if (speed > allowed_radps) {
            scale = smaller(scale, allowed_radps / speed);
        }
    }
    for (int i = 0; i < arm->joint_count; i++) {
        const arm_joint_t *joint = &arm->joints[i];
        int32_t last_steps = nearest_step(self->velocity_radps[i]);
        int32_t velocity_steps = 0;
        if (finite) {
            velocity_steps = nearest_step(scale * wanted_radps[i]);
            const bool upwards = velocity_steps > 0;
            const float way_rad =
                upwards ? joint->position_max_rad - measured_rad[i] : measured_rad[i] - joint->position_min_rad;
            const float speed_max_radps = config->speed_fraction * joint->velocity_max_radps;
            const int32_t allowed_steps = steps_below(smaller(stopping_speed(way_rad, braking_radps2, delay_s), speed_max_radps));
            velocity_steps = clamp_steps(velocity_steps, upwards ? 0 : -allowed_steps, upwards ? allowed_steps : 0);
        }
        velocity_steps = clamp_steps(velocity_steps, last_steps - change_steps, last_steps + change_steps);
        self->velocity_radps[i] = (float)velocity_steps * VELOCITY_RESOLUTION_RADPS;
        if (finite) { /* not quite to the ends, so that the rounded reference on the bus is within them */
            self->position_rad[i] = clamp(measured_rad[i] + self->velocity_radps[i] * tick_s,
                                          joint->position_min_rad + POSITION_RESOLUTION_RAD,
                                          joint->position_max_rad - POSITION_RESOLUTION_RAD);
        }
    }
    return finite;
}

uint8_t joint_limits_blocked(const arm_t *arm, const joint_limits_config_t *config, float tick_s,
                             const float measured_rad[], const float wanted_radps[]) {
    const float delay_s = config->command_delay_s + tick_s;
    const float near_rad = JOINT_LIMITS_AT_LIMIT_RAD + 0.5f * braking(config, tick_s) * delay_s * delay_s;
    uint8_t blocked = 0;
    for (int i = 0; i < arm->joint_count; i++) {
        const arm_joint_t *joint = &arm->joints[i];
        bool above = wanted_radps[i] > 0.0f && joint->position_max_rad - measured_rad[i] < near_rad;
        bool below = wanted_radps[i] < 0.0f && measured_rad[i] - joint->position_min_rad < near_rad;
        if (above || below) {
            blocked = (uint8_t)(blocked | 1u << i);
        }
    }
    return blocked;
}

bool joint_limits_at_rest(const joint_limits_t *self, const arm_t *arm) {
    for (int i = 0; i < arm->joint_count; i++) {
        if (self->velocity_radps[i] != 0.0f) {
            return false;
        }
    }
    return true;
}
