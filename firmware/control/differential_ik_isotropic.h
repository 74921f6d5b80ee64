/* The isotropic law (4), for any arm: an arm table's `isotropic`. */
#ifndef COMANIP_DIFFERENTIAL_IK_ISOTROPIC_H
#define COMANIP_DIFFERENTIAL_IK_ISOTROPIC_H

#include "differential_ik.h"

/* As differential_ik(). Where the damping turns out to be too little for it, differential_ik_general(). */
void differential_ik_isotropic(const arm_t *arm, const differential_ik_config_t *config,
                               const differential_ik_request_t *request, float velocity_radps[]);

#endif
