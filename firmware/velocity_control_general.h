/* Law (4) for any diagonals K and W and any damping, with the 8 x n Jacobian: what velocity_control() takes when its fast way
 * does not apply. */
#ifndef COMANIP_VELOCITY_CONTROL_GENERAL_H
#define COMANIP_VELOCITY_CONTROL_GENERAL_H

#include "velocity_control.h"

/* As velocity_control(). */
void velocity_control_general(const arm_t *arm, const velocity_control_config_t *config,
                              const velocity_request_t *request, float velocity_radps[]);

#endif
