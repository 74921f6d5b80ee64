/* Law (4): joint velocities from the error between the target and the hand.
 *
 *     u = (J^T W J + lambda I)^-1 J^T W K e
 *
 * the n x n form of the paper's J^T (J J^T + lambda I)^-1 K e, to which it is equal for W = I.
 *
 * It is isotropic when K and W have one value for rotation and one for translation: then it need not be taken in vec8.
 */
#ifndef COMANIP_DIFFERENTIAL_IK_H
#define COMANIP_DIFFERENTIAL_IK_H

#include <stdbool.h>

#include "../arms/arm.h"

typedef enum {
    ERROR_FRAME_TORSO = 0,  /* e = q_d - q: the paper to the letter */
    ERROR_FRAME_TARGET = 1, /* e = 1 - conj(q_d) q, Jacobian conj(q_d) J: the error's dual part is half the position
                               error, so that W is a true trade-off between position and orientation */
} error_frame_t;

/* What is constant in the normal equations, times 4, so that they are free of halves, and divided by the translation's
 * weight. */
typedef struct {
    bool applies; /* isotropic, and with so much damping that float32 solves it without refinement */
    float weight_rotation;
    float pull_rotation, pull_translation; /* 2 weight gain */
    float diagonal;                        /* of the rotation and the damping: weight_rotation + 4 lambda */
    float trace_max;                       /* of the translation's part: beyond, the damping is too little */
} differential_ik_isotropic_t;

typedef struct differential_ik_config {
    float gain_per_s[8]; /* diagonal of K, in the order of vec8; >= 0 */
    float weight[8];     /* diagonal of W; >= 0; 1 is the paper */
    float damping; /* lambda >= 0. Below 2.5e-7 of the largest diagonal of J^T W J, of all joints, which float32 does
                      not carry through, 2e-6 of it is used: the velocity stays bounded at singularities even for 0 */
    error_frame_t error_frame;
    differential_ik_isotropic_t isotropic; /* by differential_ik_prepare() */
} differential_ik_config_t;

typedef struct differential_ik_request {
    const float *position_rad; /* joint_count angles */
    const pose_t *target;      /* in the torso frame; either sign */
    joint_ends_t ends;
} differential_ik_request_t;

/* Once, after the other members of the config are set. */
void differential_ik_prepare(differential_ik_config_t *config);

/* As differential_ik(), for any diagonals K and W and any damping, with the 8 x n Jacobian: what that takes where its
 * fast way does not apply. */
void differential_ik_general(const arm_t *arm, const differential_ik_config_t *config,
                             const differential_ik_request_t *request, float velocity_radps[]);

/* velocity_radps: joint_count values, without limits. But no joint at an end goes beyond it: solved again without those
 * that would, the law lets the other joints do what they can instead of counting on them. */
static inline void differential_ik(const arm_t *arm, const differential_ik_config_t *config,
                                   const differential_ik_request_t *request, float velocity_radps[]) {
    if (config->isotropic.applies) {
        arm->isotropic(arm, config, request, velocity_radps);
    } else {
        differential_ik_general(arm, config, request, velocity_radps);
    }
}

#endif
