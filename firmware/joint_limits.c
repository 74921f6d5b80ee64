#include "joint_limits.h"

#include "can_protocol.h"
#include "comanip_schema.h"

#define VELOCITY_RESOLUTION_RADPS COMANIP_JOINT_CMD_VELOCITY_0_RADPS_RESOLUTION
#define POSITION_RESOLUTION_RAD COMANIP_JOINT_CMD_POSITION_0_RAD_RESOLUTION

/* Braking is planned with this part of the acceleration limit: the rest absorbs rounding and the encoder's noise. */
#define BRAKING_RESERVE 0.9f

/* So near to the end of its range a joint counts as standing there: below it the stopping speed is a crawl. */
#define AT_LIMIT_RAD 2e-3f

static float smaller(float a, float b) {
    return a < b ? a : b;
}

static float clamp(float x, float low, float high) {
    return x < low ? low : (x > high ? high : x);
}

static float magnitude(float x) {
    return x < 0.0f ? -x : x;
}

static bool is_finite(float x) {
    return x - x == 0.0f;
}

/* Largest speed from which a joint still stops within the distance, having travelled on for the delay first:
 * v delay + v^2 / (2 a) = distance. */
static float stopping_speed(float distance_rad, float acceleration_radps2, float delay_s) {
    if (distance_rad <= 0.0f) {
        return 0.0f;
    }
    float a = acceleration_radps2;
    return a * (__builtin_sqrtf(delay_s * delay_s + 2.0f * distance_rad / a) - delay_s);
}

/* What the law asks is K times the way to go, so that the speed falls as exp(-K t): more deceleration than there is,
 * when the speed is above a / K. Above it the speed is held to the one that stops on the way to go; below, the law's own. */
static float approach_speed(float wanted_speed_radps, const joint_limits_config_t *config) {
    float gain = config->approach_gain_per_s;
    float a = BRAKING_RESERVE * config->acceleration_max_radps2;
    float linear_speed = a / gain;
    if (!(gain > 0.0f) || wanted_speed_radps <= linear_speed) {
        return wanted_speed_radps;
    }
    /* tangent to the line u = K x at u = a / K, then v^2 = 2 a (x - a / (2 K^2)) */
    return __builtin_sqrtf(linear_speed * (2.0f * wanted_speed_radps - linear_speed));
}

/* Nearest multiple of the bus's resolution from `wanted` towards `last`, which is one: never past either. */
static float on_grid_towards(float wanted, float last) {
    float steps = (wanted - last) / VELOCITY_RESOLUTION_RADPS;
    float last_steps = last / VELOCITY_RESOLUTION_RADPS;
    int32_t grid = (int32_t)(last_steps + (last_steps < 0.0f ? -0.5f : 0.5f)) + (int32_t)steps;
    return (float)grid * VELOCITY_RESOLUTION_RADPS;
}

void joint_limits_init(joint_limits_t *self) {
    *self = (joint_limits_t){0};
}

bool joint_limits_apply(joint_limits_t *self, const arm_t *arm, const joint_limits_config_t *config, float tick_s,
                        const float measured_rad[], const float wanted_radps[]) {
    const float a_max = config->acceleration_max_radps2;
    bool finite = true;
    float scale = 1.0f; /* of all joints alike */
    for (int i = 0; i < arm->joint_count; i++) {
        finite = finite && is_finite(measured_rad[i]) && is_finite(wanted_radps[i]);
        float speed = magnitude(wanted_radps[i]);
        float allowed = smaller(config->speed_fraction * arm->joints[i].velocity_max_radps,
                                approach_speed(speed, config));
        if (speed > allowed) {
            scale = smaller(scale, allowed / speed);
        }
    }
    for (int i = 0; i < arm->joint_count; i++) {
        const arm_joint_t *joint = &arm->joints[i];
        float last = self->velocity_radps[i];
        float velocity = finite ? scale * wanted_radps[i] : 0.0f;
        if (finite) {
            float up = stopping_speed(joint->position_max_rad - measured_rad[i], BRAKING_RESERVE * a_max,
                                      config->command_delay_s);
            float down = stopping_speed(measured_rad[i] - joint->position_min_rad, BRAKING_RESERVE * a_max,
                                        config->command_delay_s);
            velocity = clamp(velocity, -down, up);
        }
        velocity = clamp(velocity, last - a_max * tick_s, last + a_max * tick_s);
        velocity = on_grid_towards(velocity, last);
        self->velocity_radps[i] = velocity;
        if (finite) {
            self->position_rad[i] = clamp(measured_rad[i] + velocity * tick_s,
                                          joint->position_min_rad + POSITION_RESOLUTION_RAD,
                                          joint->position_max_rad - POSITION_RESOLUTION_RAD);
        }
    }
    return finite;
}

bool joint_limits_exclude(const arm_t *arm, const float measured_rad[], const float wanted_radps[],
                          dual_quaternion_t column[]) {
    bool any = false;
    for (int i = 0; i < arm->joint_count; i++) {
        const arm_joint_t *joint = &arm->joints[i];
        bool above = wanted_radps[i] > 0.0f && joint->position_max_rad - measured_rad[i] < AT_LIMIT_RAD;
        bool below = wanted_radps[i] < 0.0f && measured_rad[i] - joint->position_min_rad < AT_LIMIT_RAD;
        if (above || below) {
            column[i] = (dual_quaternion_t){{0.0f, 0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f, 0.0f}};
            any = true;
        }
    }
    return any;
}

bool joint_limits_at_rest(const joint_limits_t *self, const arm_t *arm) {
    for (int i = 0; i < arm->joint_count; i++) {
        if (self->velocity_radps[i] != 0.0f) {
            return false;
        }
    }
    return true;
}
