/* Differential inverse kinematics by damped least squares, the paper's equation (4). It computes joint velocities from
 * the error between the target's pose and the end effector's:
 *
 *     u = (J^T W J + lambda I)^-1 J^T W K e
 *
 * This n x n form is equal to the paper's J^T (J J^T + lambda I)^-1 K e for W = I. Poses and e are vec8, that is, the
 * eight numbers of a dual quaternion.
 *
 * The equation is isotropic if K and W each have one value for rotation and one for translation. It can then be solved
 * without vec8, in fewer operations: see differential_ik_isotropic.c. */
#ifndef COMANIP_DIFFERENTIAL_IK_H
#define COMANIP_DIFFERENTIAL_IK_H

#include <stdbool.h>

#include "joints_at_limit.h"

typedef enum {
    ERROR_FRAME_TORSO = 0,  /* e = q_d - q, as in the paper */
    ERROR_FRAME_TARGET = 1, /* e = 1 - conj(q_d) q, Jacobian conj(q_d) J; W weighs position against orientation */
} error_frame_t;

/* Constants of the isotropic normal equations, which are multiplied by 4 to avoid factors of 1/2 and divided by the
 * translation's weight. */
typedef struct {
    bool applies; /* the equation is isotropic, and damped enough for float32 without refinement */
    float weight_rotation;
    float pull_rotation, pull_translation; /* 2 x weight x gain; after the division, the translation's weight is 1 */
    float diagonal;                        /* term on the diagonal: weight_rotation + 4 lambda / translation's weight */
    float trace_max;                       /* above this trace of J^T W J for translation, the damping is too small */
} differential_ik_isotropic_t;

typedef struct {
    float gain_per_s[8]; /* diagonal of K, in the order of vec8; >= 0 */
    float weight[8];     /* diagonal of W; >= 0; 1 in the paper */
    /* lambda >= 0. Below 2.5e-7 of the largest diagonal element of J^T W J, float32's rounding would dominate, so 2e-6
     * of that element is used instead. The velocity is therefore bounded at singularities even if lambda is 0. */
    float damping;
    error_frame_t error_frame;
    differential_ik_isotropic_t isotropic; /* set by differential_ik_prepare() */
} differential_ik_config_t;

typedef struct {
    const float *position_rad;  /* joint_count angles */
    const pose_t *target;       /* in the torso frame; either sign */
    joints_at_limit_t at_limit; /* joints at a limit, which must not be driven beyond it */
} differential_ik_request_t;

/* Sets config->isotropic. Call it once, after the other members of the config are set. */
void differential_ik_prepare(differential_ik_config_t *config);

/* Solves the equation for any K, W and damping, using the 8 x n Jacobian. velocity_radps: joint_count values, not
 * limited. */
void differential_ik_general(const arm_t *arm, const differential_ik_config_t *config,
                             const differential_ik_request_t *request, float velocity_radps[]);

#endif
