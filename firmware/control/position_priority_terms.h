/* The terms of position_priority.h's equations that the form for any arm and those written out for one have in common.
 */
#ifndef COMANIP_POSITION_PRIORITY_TERMS_H
#define COMANIP_POSITION_PRIORITY_TERMS_H

#include "../maths/float_bits.h"
#include "../maths/ldlt.h"
#include "position_priority.h"

#define POSITION_PRIORITY_DAMPING_M2 1e-5f
#define POSITION_PRIORITY_TASK_DAMPING_M2 3e-4f
#define POSITION_PRIORITY_TASK_FLOOR_M2 1e-5f
#define POSITION_PRIORITY_CURVATURE_SHARE 0.25f
#define POSITION_PRIORITY_STIFFNESS 5.0f   /* of k: holds a joint in the margin against any orientation, 2 |v| <= 2 */
#define POSITION_PRIORITY_TURN_RAD4 0.073f /* k reaches half of that at 0.52 rad, 30 degrees */

/* x: how far the joint is within the margin of its lower limit, minus how far within that of its upper one. */
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

/* The factor that shortens the position error to POSITION_PRIORITY_ERROR_MAX_M. */
static inline float position_priority_share(float distance_m) {
    return float_is_below(POSITION_PRIORITY_ERROR_MAX_M, distance_m) ? POSITION_PRIORITY_ERROR_MAX_M / distance_m
                                                                     : 1.0f;
}

/* k, of |2 v|^2. */
static inline float position_priority_stiffness(float turn_rad2) {
    const float turn_rad4 = turn_rad2 * turn_rad2;
    return POSITION_PRIORITY_STIFFNESS * turn_rad4 / (turn_rad4 + POSITION_PRIORITY_TURN_RAD4);
}

/* The cofactors of J_p J_p^T + floor I times this are the task's damping. The determinant is at least floor^2 times the
 * largest eigenvalue; where two directions are singular, rounding would leave less, or nothing. */
static inline float position_priority_task_scale(float determinant, float trace) {
    const float least =
        trace * (POSITION_PRIORITY_TASK_FLOOR_M2 * POSITION_PRIORITY_TASK_FLOOR_M2 / 3.0f + 1e-9f * trace);
    return POSITION_PRIORITY_TASK_DAMPING_M2 / (float_is_below(determinant, least) ? least : determinant);
}

/* A joint's diagonal element of D and w k, without the curvature. weighted_stiffness: w k; within_rad: x. */
static inline float position_priority_damping(float weighted_stiffness, float within_rad) {
    return POSITION_PRIORITY_DAMPING_M2 + (float_magnitude_bits(within_rad) != 0u ? weighted_stiffness : 0.0f);
}

typedef struct {
    ldlt_t normal;                                               /* M */
    float feedback[ARM_MAX_JOINTS], feedforward[ARM_MAX_JOINTS]; /* right-hand sides */
} position_priority_equations_t;

/* Solves and overwrites the equations, so that no joint goes beyond a limit it is at by the sum of both solutions. */
void position_priority_solve(position_priority_equations_t *equations, int joint_count, joints_at_limit_t at_limit,
                             float feedback_radps[], float feedforward_radps[]);

#endif
