/* Limits the position, velocity, acceleration and jerk of each joint. Every command passes through here, regardless of
 * demand and state.
 *
 * Let j be the jerk limit, K the largest gain of the feedback, and a be JOINT_LIMITS_BRAKING_RESERVE times the
 * acceleration limit, but at most sqrt(0.1 rad/s j). Both the jerk limit and the acceleration limit are first rounded
 * down to whole steps of the bus's resolution. The rules are:
 *
 *   approach  A feedback speed u above a/K is lowered to sqrt(a/K (2 u - a/K)), from which the joint stops within the
 *             remaining distance; all joints are scaled by the same factor. The feedforward is added as is.
 *   speed     All joints are scaled by the same factor to keep within their speed limits, so that the end effector
 *             keeps its direction of motion.
 *   range     Towards a limit at distance d, the speed is at most
 *             sqrt(2 a d + (a^2/2j)^2) - a^2/j - a (command_delay_s + tick_s). One half of a^2/j allows for the
 *             growth of the deceleration, the other for the lag of the velocity behind this speed.
 *   change    In each tick, the velocity changes by at most the acceleration limit times tick_s, and this change
 *             differs from that of the last tick by at most the jerk limit times tick_s^2. The change decreases to 0 in
 *             time, so that the velocity does not overshoot the value allowed by the rules above.
 *
 * From every reachable state, a joint with a demand of 0 comes to rest within v/a + 2.5 a/j + 2 ticks, where v is its
 * speed and a is, unlike above, the acceleration limit itself. */
#ifndef COMANIP_JOINT_LIMITS_H
#define COMANIP_JOINT_LIMITS_H

#include <stdbool.h>

#include "../arms/arm.h"

/* Braking is planned with this share of the acceleration limit. The rest absorbs rounding and encoder noise. */
#define JOINT_LIMITS_BRAKING_RESERVE 0.9f

/* A joint is treated as being at its limit as soon as it is this close to the point at which its stopping speed becomes
 * 0, because it would only creep towards that point. */
#define JOINT_LIMITS_AT_LIMIT_RAD 2e-3f

/* Constants of a joint, derived from the config and the arm. */
typedef struct {
    int32_t change_max_steps;  /* largest change of the velocity per tick */
    int32_t jerk_steps;        /* largest difference between the changes in two successive ticks, >= 1 */
    float ramp_ticks_per_step; /* number of ticks in which a change of one step decreases to 0 */
    float speed_max_radps;
    float braking_radps2; /* a, the deceleration used for planning */
    float linear_radps;   /* a / K, below which the approach rule keeps the demanded speed */
    float twice_braking_radps2;
    float ramp_square;       /* (a^2 / (2 j))^2; the speed a^2 / (2 j) is lost while the deceleration grows to a */
    float fastest_square;    /* if the squared speed reaches this, the stopping speed is speed_max_radps */
    float coasting_radps;    /* subtracted from the stopping speed, because braking takes effect with a delay */
    float reference_min_rad; /* lower limit of the reference: the joint's limit plus one step of the bus's resolution */
    float reference_max_rad; /* upper limit, likewise; a rounded reference is thus within the joint's limits */
} joint_limits_plan_t;

typedef struct {
    float tick_s;                  /* > 0 */
    float speed_fraction;          /* fraction of each joint's velocity_max_radps, 0..1 */
    float acceleration_max_radps2; /* > 0 */
    float command_delay_s;         /* time from the command to the drive's motion */
    float approach_gain_per_s;     /* largest gain K of the feedback, whose velocity is K times the distance */
    /* set by joint_limits_prepare(): */
    joint_limits_plan_t plan[ARM_MAX_JOINTS];
    float at_limit_rad[ARM_MAX_JOINTS]; /* a joint nearer than this to a limit is treated as at that limit */
} joint_limits_config_t;

/* Derives `plan` and `at_limit_rad`. Call it once, after the other members of the config are set. */
void joint_limits_prepare(joint_limits_config_t *config, const arm_t *arm);

/* State: the last command. */
typedef struct {
    float position_rad[ARM_MAX_JOINTS];     /* reference for the next tick, within the arm's range */
    int32_t velocity_steps[ARM_MAX_JOINTS]; /* velocity in steps of the bus's resolution */
    int32_t change_steps[ARM_MAX_JOINTS];   /* change of the velocity from the previous command */
    float velocity_radps[ARM_MAX_JOINTS];   /* the same velocity in rad/s */
} joint_limits_t;

void joint_limits_init(joint_limits_t *self);

/* Computes the command and leaves it in self. measured_rad, feedback_radps, feedforward_radps: joint_count values each.
 * The feedback velocities correct the error and are subject to the approach rule; the feedforward velocities are those
 * of the target's motion. Commanded velocities are whole multiples of the bus's resolution (1 mrad/s), so that exactly
 * the limited values are sent. Returns false and brakes if a value, or the sum of a joint's velocities, is not
 * finite. */
bool joint_limits_apply(joint_limits_t *self, const arm_t *arm, const joint_limits_config_t *config,
                        const float measured_rad[], const float feedback_radps[], const float feedforward_radps[]);

/* Returns true if all commanded velocities and their changes are 0. */
bool joint_limits_at_rest(const joint_limits_t *self, const arm_t *arm);

#endif
