/* Whether parameters that are each within their range can work together: checked as a set when it comes into force, as
 * they are written one by one.
 *
 * About its target the law is e' = -P K e, with P = J (J^T W J + D)^-1 J^T W: similar to a symmetric matrix with
 * eigenvalues from 0 to 1, so that no error shrinks faster than exp(-k t), k the largest gain of a component with a
 * weight, in whatever posture. With the loop's delay T that is stable below k T = pi / 2, and rings above some half of
 * it.
 *
 * What is slow is never unstable: no lower bound for gains, speed or acceleration. */
#ifndef COMANIP_PARAMETER_SET_H
#define COMANIP_PARAMETER_SET_H

#include "parameters.h"

typedef enum {
    PARAMETER_SET_RESTS,     /* when the hand rests, the arm comes to rest */
    PARAMETER_SET_MAY_SWING, /* it may not: the law of before the prediction, and the paper's */
    PARAMETER_SET_UNSTABLE,  /* it will not: not to come into force */
} parameter_set_verdict_t;

typedef struct {
    parameter_set_verdict_t verdict;
    uint64_t involved; /* parameters, a bit each, that make it unstable together */
} parameter_set_t;

/* tick_s: the control period, > 0. */
parameter_set_t parameter_set_check(const parameters_t *parameters, float tick_s);

#endif
