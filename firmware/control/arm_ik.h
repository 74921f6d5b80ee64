/* An arm and the functions of its inverse kinematics: either those that `make arms` generated for this arm (arms/), or
 * those that work for any arm. */
#ifndef COMANIP_ARM_IK_H
#define COMANIP_ARM_IK_H

#include "differential_ik.h"
#include "position_priority.h"

typedef void arm_ik_isotropic_t(const arm_t *arm, const differential_ik_config_t *config,
                                const differential_ik_request_t *request, float velocity_radps[]);
typedef float arm_ik_position_priority_t(const arm_t *arm, const position_priority_config_t *config,
                                         const position_priority_request_t *request, float feedback_radps[],
                                         float feedforward_radps[]);

typedef struct {
    const arm_t *arm;
    arm_ik_isotropic_t *isotropic;                 /* equivalent to differential_ik_isotropic() */
    arm_ik_position_priority_t *position_priority; /* equivalent to position_priority() */
} arm_ik_t;

/* Returns the arm with the functions that work for any arm. The arm must outlive the result. */
arm_ik_t arm_ik_any(const arm_t *arm);

/* Returns NULL if all members are set and arm_check() finds no defect, otherwise a one-line message that names the
 * defect. */
const char *arm_ik_check(const arm_ik_t *self);

/* Computes the paper's differential inverse kinematics. velocity_radps: joint_count values, not limited. */
static inline void arm_ik_differential(const arm_ik_t *self, const differential_ik_config_t *config,
                                       const differential_ik_request_t *request, float velocity_radps[]) {
    if (config->isotropic.applies) {
        self->isotropic(self->arm, config, request, velocity_radps);
    } else {
        differential_ik_general(self->arm, config, request, velocity_radps);
    }
}

/* See position_priority(). */
static inline float arm_ik_position_priority(const arm_ik_t *self, const position_priority_config_t *config,
                                             const position_priority_request_t *request, float feedback_radps[],
                                             float feedforward_radps[]) {
    return self->position_priority(self->arm, config, request, feedback_radps, feedforward_radps);
}

#endif
