/* The only way out to a command: position, velocity, acceleration and jerk of each joint stay within limits, whatever
 * is asked, and whatever happened.
 *
 * With j the jerk limit and a = JOINT_LIMITS_BRAKING_RESERVE times the acceleration limit, but at most sqrt(0.1 rad/s
 * j) (all in whole steps of the bus's resolution per tick): approach  above a/K, the speed u asked for the error is
 * lowered to sqrt(a/K (2 u - a/K)), from which a joint stops on the way to go, all joints in proportion; the speed fed
 * forward is the target's own, and is added as it is; speed     all joints in proportion, so that the hand keeps its
 * direction; range     towards an end at distance d, at most sqrt(2 a d + (a^2/2j)^2) - a^2/j - a (command_delay_s +
 * tick_s), of which the first a^2/2j is the deceleration's growth, and the second what the velocity lags behind this
 * speed; change    per tick at most the acceleration limit times the tick, and from one tick to the next at most the
 * jerk limit times tick^2; it comes down to 0 in time for the velocity to end at what the rules above allow, and not
 * beyond. From any state that this leads to, a joint asked to stand does within v/a + 2.5 a/j + 2 ticks, a being the
 * acceleration limit. */
#ifndef COMANIP_JOINT_LIMITS_H
#define COMANIP_JOINT_LIMITS_H

#include <stdbool.h>

#include "../arms/arm.h"

/* Braking is planned with this part of the acceleration limit: the rest absorbs rounding and the encoder's noise. */
#define JOINT_LIMITS_BRAKING_RESERVE 0.9f

/* A joint is treated as at its limit this much before its stopping speed becomes 0: from there on it only creeps. */
#define JOINT_LIMITS_AT_LIMIT_RAD 2e-3f

/* Of a joint: what follows from the config and the arm. */
typedef struct {
    int32_t change_max_steps;  /* of the velocity, in a tick */
    int32_t jerk_steps;        /* by which that change differs from the last tick's at most, >= 1 */
    float ramp_ticks_per_step; /* of the change, until it has come down to 0 */
    float speed_max_radps;
    float braking_radps2; /* the deceleration to plan with, a */
    float linear_radps;   /* a / K: below it the law's own speed is kept */
    float twice_braking_radps2;
    float ramp_square;    /* (a^2 / (2 j))^2: of what the speed changes by while the deceleration grows to a */
    float fastest_square; /* of the stopping speed from which on speed_max_radps holds */
    float coasting_radps; /* what is lost of the stopping speed to that, and to commands under way */
    float reference_min_rad,
        reference_max_rad; /* not quite the ends, so that the rounded reference on the bus is within them */
} joint_limits_plan_t;

typedef struct {
    float tick_s;                  /* > 0 */
    float speed_fraction;          /* 0..1 of each joint's velocity_max_radps */
    float acceleration_max_radps2; /* > 0 */
    float command_delay_s;         /* from this tick to the drive's motion: joints travel on for so long */
    float approach_gain_per_s; /* the law's largest gain K: what it asks for the error is K times the way to go, so the
                                  speed from which a joint can still stop on that way is known */
    /* by joint_limits_prepare() */
    joint_limits_plan_t plan[ARM_MAX_JOINTS];
    float at_limit_rad[ARM_MAX_JOINTS]; /* a joint nearer to a limit is at that limit */
} joint_limits_config_t;

/* Once, after the other members of the config are set. */
void joint_limits_prepare(joint_limits_config_t *config, const arm_t *arm);

/* The last command. */
typedef struct {
    float position_rad[ARM_MAX_JOINTS];     /* where the joint is to be at the next tick, within the arm's range */
    int32_t velocity_steps[ARM_MAX_JOINTS]; /* of the bus's resolution */
    int32_t change_steps[ARM_MAX_JOINTS];   /* of it, from the command before */
    float velocity_radps[ARM_MAX_JOINTS];   /* the same velocities */
} joint_limits_t;

void joint_limits_init(joint_limits_t *self);

/* measured_rad, feedback_radps, feedforward_radps: joint_count values; the law's velocities for the error that is left,
 * which the approach rule brakes, and those of the target's own motion. The command is left in self; its velocities are
 * whole multiples of the bus's resolution (1 mrad/s), so that what is limited is what is sent. Returns false, and
 * brakes, if a value is not finite, or the sum of a joint's velocities is not. */
bool joint_limits_apply(joint_limits_t *self, const arm_t *arm, const joint_limits_config_t *config,
                        const float measured_rad[], const float feedback_radps[], const float feedforward_radps[]);

bool joint_limits_at_rest(const joint_limits_t *self, const arm_t *arm);

#endif
