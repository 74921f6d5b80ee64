/* Isotropic differential inverse kinematics, for any arm. */
#ifndef COMANIP_DIFFERENTIAL_IK_ISOTROPIC_H
#define COMANIP_DIFFERENTIAL_IK_ISOTROPIC_H

#include "differential_ik.h"

/* Computes the same velocities as differential_ik_general(), but faster. Calls that function instead if the damping is
 * too small in the current posture. Requires config->isotropic.applies. */
void differential_ik_isotropic(const arm_t *arm, const differential_ik_config_t *config,
                               const differential_ik_request_t *request, float velocity_radps[]);

#endif
