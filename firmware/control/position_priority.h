/* Position-priority differential inverse kinematics: the end effector follows a moving target, its position before its
 * orientation, and comes to rest wherever it cannot follow.
 *
 * The joint velocities descend the gradient of
 *
 *     V = 1/2 h(|p|) + w (1/2 |2 v|^2 + 1/2 k sum x_i^2)
 *
 * - p: the position error [m];
 * - v: the vector part of the error's quaternion, so that 2 v is nearly the rotation vector;
 * - x_i: how far joint i is within POSITION_PRIORITY_MARGIN_RAD of a limit;
 * - k: the stiffness of that margin, larger the larger the orientation error is (its own derivative is left out);
 * - h(p) = p^2, continued linearly beyond POSITION_PRIORITY_ERROR_MAX_M: an error that is longer counts as if it were
 *   that long.
 *
 * With J = (J_p, J_r) the geometric Jacobian, e the position error so shortened, and xi the target's own twist,
 *
 *     M [u_feedback u_feedforward] = [K (J_p^T e + w (2 J_r^T v + k x))   J_p^T xi_p + w J_r^T xi_r]
 *     M = J_p^T A J_p + w (J_r^T J_r + k) + D
 *
 * M is positive definite, so that V only falls while k is constant and the target stands still: the arm comes to rest.
 *
 * - w is so small that the position gives way by a few tenths of a millimetre at most.
 * - The margin keeps an unreachable orientation from driving joints to their limits, where the position would be lost.
 *   A reachable orientation is reached.
 * - A = I + damping (J_p J_p^T)^-1 damps directions of the position only: neither noise nor tremor is amplified near a
 *   singular posture, and the freedom that is left to the orientation keeps its rate.
 * - D = a little damping, and a share of what Gauss-Newton's J_p^T J_p leaves out of V's Hessian: on the diagonal
 *   sum_j |(a_min(i,j) x e) . m_max(i,j)|, Gershgorin's bound, with the joints' axes a and moments m. It keeps the
 *   loop's rate at K where the arm is stretched out towards a target beyond its reach. */
#ifndef COMANIP_POSITION_PRIORITY_H
#define COMANIP_POSITION_PRIORITY_H

#include "joints_at_limit.h"

#define POSITION_PRIORITY_ERROR_MAX_M 0.015f
#define POSITION_PRIORITY_MARGIN_RAD 0.6f

typedef struct {
    float gain_per_s; /* K > 0 */
    float
        orientation_weight_m2; /* w >= 0: an orientation error of 1 rad counts as much as this squared position error */
} position_priority_config_t;

typedef struct {
    const float *position_rad;  /* joint_count angles */
    const pose_t *target;       /* in the torso frame; either sign */
    const twist_t *motion;      /* the target's own, in the torso frame */
    joints_at_limit_t at_limit; /* none of them is driven beyond by the sum of feedback and feedforward */
} position_priority_request_t;

/* feedback_radps, feedforward_radps: joint_count values each, not limited. Returns the position error [m]. For any arm;
 * arm_ik_position_priority() takes what is written out for one. */
float position_priority(const arm_t *arm, const position_priority_config_t *config,
                        const position_priority_request_t *request, float feedback_radps[], float feedforward_radps[]);

#endif
