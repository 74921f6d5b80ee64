/* Position-priority differential inverse kinematics: the end effector follows a moving target, with position taking
 * priority over orientation, and comes to rest where it cannot follow.
 *
 * The joint velocities descend the gradient of
 *
 *     V = 1/2 h(|p|) + w (1/2 |2 v|^2 + 1/2 k sum x_i^2)
 *
 * - p: the position error [m];
 * - v: the vector part of the error's quaternion, so that 2 v is nearly the rotation vector;
 * - x_i: how far joint i has entered the margin of POSITION_PRIORITY_MARGIN_RAD before a limit;
 * - k: the stiffness of that margin, which grows with the orientation error (the derivative of k is neglected);
 * - h(p) = p^2, continued linearly beyond POSITION_PRIORITY_ERROR_MAX_M: an error longer than that is shortened to that
 *   length.
 *
 * With the geometric Jacobian J = (J_p, J_r), the shortened position error e and the target's twist xi, the equations
 * are
 *
 *     M [u_feedback u_feedforward] = [K (J_p^T e + w (2 J_r^T v + k x))   J_p^T xi_p + w J_r^T xi_r]
 *     M = J_p^T A J_p + w (J_r^T J_r + k) + D
 *
 * M is positive definite, so V decreases while k is constant and the target is at rest, and the arm comes to rest.
 *
 * - w is so small that the orientation changes the reached position by at most a few tenths of a millimetre.
 * - The margin keeps an unreachable orientation from driving joints to their limits, where the position would be lost.
 *   A reachable orientation is reached.
 * - A = I + damping (J_p J_p^T)^-1 damps only the translation. Near a singularity, this prevents the amplification of
 *   noise and tremor without slowing down the rotation.
 * - D is a small damping plus a share of Gershgorin's bound for the terms of V's Hessian that J_p^T J_p (Gauss-Newton)
 *   omits. The bound is a diagonal matrix with the elements sum_j |(a_min(i,j) x e) . m_max(i,j)|, where a and m are
 *   the joints' axes and moments. This share keeps the loop's rate at K when the arm is stretched out towards a target
 *   out of reach. */
#ifndef COMANIP_POSITION_PRIORITY_H
#define COMANIP_POSITION_PRIORITY_H

#include "joints_at_limit.h"

#define POSITION_PRIORITY_ERROR_MAX_M 0.015f
#define POSITION_PRIORITY_MARGIN_RAD 0.6f

typedef struct {
    float gain_per_s;            /* K > 0 */
    float orientation_weight_m2; /* w >= 0: the squared position error equivalent to an orientation error of 1 rad */
} position_priority_config_t;

typedef struct {
    const float *position_rad;  /* joint_count angles */
    const pose_t *target;       /* in the torso frame; either sign */
    const twist_t *motion;      /* the target's twist, in the torso frame */
    joints_at_limit_t at_limit; /* feedback plus feedforward must not drive these joints beyond their limits */
} position_priority_request_t;

/* Solves the equations for any arm; arm_ik_position_priority() uses the code generated for the arm, if there is any.
 * feedback_radps, feedforward_radps: joint_count values each, not limited. Returns the position error [m]. */
float position_priority(const arm_t *arm, const position_priority_config_t *config,
                        const position_priority_request_t *request, float feedback_radps[], float feedforward_radps[]);

#endif
