/* Inverse kinematics of any arm: see arm_ik.h. */
#include "arm_ik.h"

#include <stddef.h>

#include "differential_ik_isotropic.h"

arm_ik_t arm_ik_any(const arm_t *arm) {
    return (arm_ik_t){arm, differential_ik_isotropic, position_priority};
}

const char *arm_ik_check(const arm_ik_t *self) {
    if (self->arm == NULL || self->isotropic == NULL || self->position_priority == NULL) {
        return "arm's inverse kinematics: arm, isotropic and position_priority must be set: see arm_ik_any()";
    }
    return arm_check(self->arm);
}
