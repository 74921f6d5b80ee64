/* Law (4) where joints stand at an end of their range: those that it sends beyond are left out, and the rest is solved
 * again, until none is sent beyond. */
#ifndef COMANIP_JOINT_ENDS_H
#define COMANIP_JOINT_ENDS_H

#include "../maths/ldlt.h"
#include "differential_ik.h"

/* Adds to *out the joints, a bit each, that are sent beyond the end at which they stand. Returns those that were not in
 * it: as long as it is not 0 the equations are to be solved again, without them, which is joint_count times at most. */
uint8_t joint_ends_leave_out(joint_ends_t ends, int joint_count, const float velocity_radps[], uint8_t *out);

/* velocity_radps: the normal equations' right-hand side, then their solution. Of `normal` the joints that would go
 * beyond are left out. */
void joint_ends_solve(joint_ends_t ends, int joint_count, ldlt_t *normal, float velocity_radps[]);

#endif
