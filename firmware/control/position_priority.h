/* The law that follows a moving target: its position first, then its orientation, and to rest wherever it cannot be
 * followed.
 *
 * Joint velocities go down the gradient of
 *
 *     V = 1/2 h(|p|) + w (1/2 |2 v|^2 + 1/2 k sum x_i^2)
 *
 * with p the position error [m], v the vector part of the error's quaternion (2 v is nearly the rotation vector), x_i
 * how far joint i is within POSITION_PRIORITY_MARGIN_RAD of an end of its range, k the larger the more the orientation
 * is off (its own derivative is left out), and h(p) = p^2, but linear beyond POSITION_PRIORITY_ERROR_MAX_M: as if the
 * error were no longer than that. With J = (J_p, J_r) the hand's Jacobian, e that error, and xi the target's own twist,
 *
 *     (J_p^T A J_p + w (J_r^T J_r + k) + D) [u_error u_motion] = [K (J_p^T e + w (2 J_r^T v + k x))   J_p^T xi_p + w
 * J_r^T xi_r].
 *
 * The matrix is positive definite, so that for a constant k and a target that stands V only falls, and the arm comes to
 * rest.
 *
 *   w       is so small that position gives way by a few tenths of a millimetre at most.
 *   margin  keeps an orientation that cannot be reached from driving joints to their ends, where the position would be
 * lost. A reachable orientation is met. A       = I + damping (J_p J_p^T)^-1 damps the directions of the position
 * alone: neither noise nor tremor is magnified near a singular posture, and the freedom that is left to the orientation
 * keeps its rate. D       = a little damping + a share of what Gauss-Newton's J_p^T J_p leaves out of V's Hessian: on
 * the diagonal sum_j |(a_min(i,j) x e) . m_max(i,j)|, Gershgorin's bound, with the joints' axes a and moments m. Where
 * the arm is stretched out after a target beyond its reach, it keeps the loop's rate at K. */
#ifndef COMANIP_POSITION_PRIORITY_H
#define COMANIP_POSITION_PRIORITY_H

#include "../arms/arm.h"

#define POSITION_PRIORITY_ERROR_MAX_M 0.015f
#define POSITION_PRIORITY_MARGIN_RAD 0.6f

typedef struct position_priority_config {
    float gain_per_s; /* K > 0 */
    float
        orientation_weight_m2; /* w >= 0: how much an orientation error of 1 rad counts, as a position error squared */
} position_priority_config_t;

typedef struct position_priority_request {
    const float *position_rad; /* joint_count angles */
    const pose_t *target;      /* in the torso frame; either sign */
    const twist_t *motion;     /* the target's own, in the torso frame */
    joint_ends_t ends;
} position_priority_request_t;

/* feedback_radps, feedforward_radps: joint_count values each, without limits. No joint at an end goes beyond it by
 * their sum. Returns the position error [m]. Of any arm; arm->position_priority() is faster where it can be. */
float position_priority(const arm_t *arm, const position_priority_config_t *config,
                        const position_priority_request_t *request, float feedback_radps[], float feedforward_radps[]);

#endif
