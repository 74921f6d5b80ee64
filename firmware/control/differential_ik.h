/* Differential inverse kinematics by damped least squares, the paper's equation (4): joint velocities from the error
 * between the target's pose and the end effector's.
 *
 *     u = (J^T W J + lambda I)^-1 J^T W K e
 *
 * This is the n x n form of the paper's J^T (J J^T + lambda I)^-1 K e, to which it is equal for W = I. Poses and e are
 * vec8: a dual quaternion's eight numbers.
 *
 * The equation is isotropic if K and W have one value for rotation and one for translation: then it need not be
 * evaluated in vec8. arm_ik.h selects the form. */
#ifndef COMANIP_DIFFERENTIAL_IK_H
#define COMANIP_DIFFERENTIAL_IK_H

#include <stdbool.h>

#include "joints_at_limit.h"

typedef enum {
    ERROR_FRAME_TORSO = 0,  /* e = q_d - q: the paper to the letter */
    ERROR_FRAME_TARGET = 1, /* e = 1 - conj(q_d) q, Jacobian conj(q_d) J: the error's dual part is half the position
                               error, so that W is a true trade-off between position and orientation */
} error_frame_t;

/* The constants of the isotropic normal equations: multiplied by 4, so that they are free of halves, and divided by the
 * translation's weight. */
typedef struct {
    bool applies; /* isotropic, and with so much damping that float32 solves it without refinement */
    float weight_rotation;
    float pull_rotation, pull_translation; /* 2 weight gain */
    float diagonal;                        /* of the rotation and the damping: weight_rotation + 4 lambda */
    float trace_max; /* of the translation's part of J^T W J: above it the damping is too little */
} differential_ik_isotropic_t;

typedef struct {
    float gain_per_s[8]; /* diagonal of K, in the order of vec8; >= 0 */
    float weight[8];     /* diagonal of W; >= 0; 1 is the paper */
    float damping; /* lambda >= 0. Below 2.5e-7 of the largest diagonal element of J^T W J, where float32's rounding
                      would decide, 2e-6 of that element is used: the velocity is bounded at singularities even for 0 */
    error_frame_t error_frame;
    differential_ik_isotropic_t isotropic; /* by differential_ik_prepare() */
} differential_ik_config_t;

typedef struct {
    const float *position_rad;  /* joint_count angles */
    const pose_t *target;       /* in the torso frame; either sign */
    joints_at_limit_t at_limit; /* none of them is driven beyond */
} differential_ik_request_t;

/* Once, after the other members of the config are set. */
void differential_ik_prepare(differential_ik_config_t *config);

/* For any K, W and damping, with the 8 x n Jacobian. velocity_radps: joint_count values, not limited. */
void differential_ik_general(const arm_t *arm, const differential_ik_config_t *config,
                             const differential_ik_request_t *request, float velocity_radps[]);

#endif
