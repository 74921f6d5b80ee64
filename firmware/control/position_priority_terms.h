/* Terms of the equations of position_priority.h, shared by the code for any arm and the code generated for one arm. */
#ifndef COMANIP_POSITION_PRIORITY_TERMS_H
#define COMANIP_POSITION_PRIORITY_TERMS_H

#include "../maths/float_bits.h"
#include "../maths/ldlt.h"
#include "position_priority.h"

#define POSITION_PRIORITY_DAMPING_M2 1e-5f
#define POSITION_PRIORITY_TASK_DAMPING_M2 3e-4f
#define POSITION_PRIORITY_TASK_FLOOR_M2 1e-5f
#define POSITION_PRIORITY_CURVATURE_SHARE 0.25f
#define POSITION_PRIORITY_STIFFNESS 5.0f   /* greatest k; stops a joint within its margin at any orientation error */
#define POSITION_PRIORITY_TURN_RAD4 0.073f /* k is half its greatest value at 0.52 rad, 30 degrees */

/* Returns x, the joint's depth in the margin of its lower limit minus its depth in the margin of its upper limit. */
static inline float position_priority_margin(float min_rad, float max_rad, float position_rad) {
    const float above_lower_rad = position_rad - min_rad;
    const float below_upper_rad = max_rad - position_rad;
    float within_rad = 0.0f;
    within_rad += float_is_below(above_lower_rad, POSITION_PRIORITY_MARGIN_RAD)
                      ? POSITION_PRIORITY_MARGIN_RAD - above_lower_rad
                      : 0.0f;
    within_rad -= float_is_below(below_upper_rad, POSITION_PRIORITY_MARGIN_RAD)
                      ? POSITION_PRIORITY_MARGIN_RAD - below_upper_rad
                      : 0.0f;
    return within_rad;
}

/* Returns the factor that shortens the position error to POSITION_PRIORITY_ERROR_MAX_M. */
static inline float position_priority_share(float distance_m) {
    return float_is_below(POSITION_PRIORITY_ERROR_MAX_M, distance_m) ? POSITION_PRIORITY_ERROR_MAX_M / distance_m
                                                                     : 1.0f;
}

/* Returns k as a function of |2 v|^2. */
static inline float position_priority_stiffness(float turn_rad2) {
    const float turn_rad4 = turn_rad2 * turn_rad2;
    return POSITION_PRIORITY_STIFFNESS * turn_rad4 / (turn_rad4 + POSITION_PRIORITY_TURN_RAD4);
}

/* Returns the factor by which the cofactors of J_p J_p^T + floor I must be multiplied to obtain A - I. The determinant
 * is at least floor^2 times the largest eigenvalue. If two directions are singular, rounding may make the computed
 * determinant smaller, so a lower bound is applied. */
static inline float position_priority_task_scale(float determinant, float trace) {
    const float least =
        trace * (POSITION_PRIORITY_TASK_FLOOR_M2 * POSITION_PRIORITY_TASK_FLOOR_M2 / 3.0f + 1e-9f * trace);
    return POSITION_PRIORITY_TASK_DAMPING_M2 / (float_is_below(determinant, least) ? least : determinant);
}

/* Returns a joint's diagonal element of D, except for the share of Gershgorin's bound, plus w k if the joint is in a
 * margin. weighted_stiffness: w k. within_rad: x. */
static inline float position_priority_damping(float weighted_stiffness, float within_rad) {
    return POSITION_PRIORITY_DAMPING_M2 + (float_magnitude_bits(within_rad) != 0u ? weighted_stiffness : 0.0f);
}

typedef struct {
    ldlt_t normal;                                               /* M */
    float feedback[ARM_MAX_JOINTS], feedforward[ARM_MAX_JOINTS]; /* right-hand sides */
} position_priority_equations_t;

/* Solves and overwrites the equations. The sum of the two solutions never drives a joint beyond a limit that it has
 * reached. */
void position_priority_solve(position_priority_equations_t *equations, int joint_count, joints_at_limit_t at_limit,
                             float feedback_radps[], float feedforward_radps[]);

#endif
