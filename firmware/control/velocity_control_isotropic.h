/* The isotropic law (4), for any arm: an arm table's `isotropic`. */
#ifndef COMANIP_VELOCITY_CONTROL_ISOTROPIC_H
#define COMANIP_VELOCITY_CONTROL_ISOTROPIC_H

#include "velocity_control.h"

/* As velocity_control(). Where the damping turns out to be too little for it, velocity_control_general(). */
void velocity_control_isotropic(const arm_t *arm, const velocity_control_config_t *config,
                                const velocity_request_t *request, float velocity_radps[]);

#endif
