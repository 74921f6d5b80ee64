/* Law (4): joint velocities from the error between the target and the measured hand.
 *
 *     u = (J^T W J + lambda I)^-1 J^T W K e
 *
 * the n x n form of the paper's J^T (J J^T + lambda I)^-1 K e, to which it is equal for W = I. */
#ifndef COMANIP_VELOCITY_CONTROL_H
#define COMANIP_VELOCITY_CONTROL_H

#include "arm.h"

typedef enum {
    ERROR_FRAME_TORSO = 0,  /* e = q_d - q: the paper to the letter */
    ERROR_FRAME_TARGET = 1, /* e = 1 - conj(q_d) q, Jacobian conj(q_d) J: the error's dual part is half the position
                               error, so that W is a true trade-off between position and orientation */
} error_frame_t;

typedef struct {
    float gain_per_s[8]; /* diagonal of K, in the order of vec8; >= 0 */
    float weight[8];     /* diagonal of W; >= 0; 1 is the paper */
    float damping;       /* lambda >= 0. Below 2.5e-7 of the largest diagonal of J^T W J, which float32 does not carry
                               through, 2e-6 of it is used: the velocity stays bounded at singularities even for 0 */
    error_frame_t error_frame;
} velocity_control_config_t;

/* hand, half_line: as arm_hand_and_axes() gives them; a half_line of 0 takes its joint out. target: unit, either sign.
 * velocity_radps: joint_count values, without limits. Cost is fixed for a given joint_count. */
void velocity_control(const velocity_control_config_t *config, int joint_count, dual_quaternion_t hand,
                      const dual_quaternion_t half_line[], dual_quaternion_t target, float velocity_radps[]);

#endif
