/* What the law has in common, for any arm and as `make arms` writes it out for one: position_priority.h has the equations. */
#ifndef COMANIP_POSITION_PRIORITY_TERMS_H
#define COMANIP_POSITION_PRIORITY_TERMS_H

#include "../maths/float_bits.h"
#include "../maths/ldlt.h"
#include "position_priority.h"

#define POSITION_PRIORITY_DAMPING_M2 1e-5f
#define POSITION_PRIORITY_TASK_DAMPING_M2 3e-4f
#define POSITION_PRIORITY_TASK_FLOOR_M2 1e-5f
#define POSITION_PRIORITY_CURVATURE_SHARE 0.25f
#define POSITION_PRIORITY_STIFFNESS 5.0f /* of k: holds a joint in the margin against any orientation, 2 |v| <= 2 */
#define POSITION_PRIORITY_TURN_RAD4 0.073f /* k reaches half of that at 0.52 rad, 30 degrees */

/* How far the joint is within the margin of its lower end, less of its upper end. */
static inline float position_priority_out_of_margin(const arm_joint_t *joint, float position_rad) {
    const float above_lower_rad = position_rad - joint->position_min_rad;
    const float below_upper_rad = joint->position_max_rad - position_rad;
    float way_rad = 0.0f;
    way_rad += float_is_below(above_lower_rad, POSITION_PRIORITY_MARGIN_RAD) ? POSITION_PRIORITY_MARGIN_RAD - above_lower_rad : 0.0f;
    way_rad -= float_is_below(below_upper_rad, POSITION_PRIORITY_MARGIN_RAD) ? POSITION_PRIORITY_MARGIN_RAD - below_upper_rad : 0.0f;
    return way_rad;
}

/* How much of the position error counts. */
static inline float position_priority_share(float distance_m) {
    return float_is_below(POSITION_PRIORITY_ERROR_MAX_M, distance_m) ? POSITION_PRIORITY_ERROR_MAX_M / distance_m : 1.0f;
}

/* k, of |2 v|^2. */
static inline float position_priority_stiffness(float turned_rad2) {
    const float turned_rad4 = turned_rad2 * turned_rad2;
    return POSITION_PRIORITY_STIFFNESS * turned_rad4 / (turned_rad4 + POSITION_PRIORITY_TURN_RAD4);
}

/* What the cofactors of J_p J_p^T + floor I are to be multiplied with, for the task's damping. The determinant is at least floor^2 times the
 * largest eigenvalue; where the arm is singular twice, rounding would leave less, or nothing. */
static inline float position_priority_task_scale(float determinant, float trace) {
    const float least = trace * (POSITION_PRIORITY_TASK_FLOOR_M2 * POSITION_PRIORITY_TASK_FLOOR_M2 / 3.0f + 1e-9f * trace);
    return POSITION_PRIORITY_TASK_DAMPING_M2 / (float_is_below(determinant, least) ? least : determinant);
}

/* Of a joint, on the diagonal: without the curvature. weighted_stiffness: w k. */
static inline float position_priority_damping(float weighted_stiffness, float way_out_rad) {
    return POSITION_PRIORITY_DAMPING_M2 + (float_magnitude_bits(way_out_rad) != 0u ? weighted_stiffness : 0.0f);
}

typedef struct {
    ldlt_t normal;
    float error[ARM_MAX_JOINTS], motion[ARM_MAX_JOINTS]; /* right-hand sides */
} position_priority_equations_t;

/* Solves them, in their place. No joint at an end goes beyond it by the sum of both solutions: those that would are left out. */
void position_priority_solve(position_priority_equations_t *equations, int joint_count, joint_ends_t ends, float feedback_radps[],
                          float feedforward_radps[]);

#endif
