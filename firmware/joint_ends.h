/* Law (4) where joints stand at an end of their range: those that it sends beyond are taken out, and the rest is solved again, until none
 * is sent beyond. */
#ifndef COMANIP_JOINT_ENDS_H
#define COMANIP_JOINT_ENDS_H

#include "ldlt.h"
#include "velocity_control.h"

/* The joints, a bit each, that are sent beyond the end at which they stand. */
uint8_t joint_ends_beyond(const velocity_request_t *request, int joint_count, const float velocity_radps[]);

/* velocity_radps: the normal equations' right-hand side, then their solution. Of `normal` the joints that would go beyond are left out. */
void joint_ends_solve(const velocity_request_t *request, int joint_count, ldlt_t *normal, float velocity_radps[]);

#endif
