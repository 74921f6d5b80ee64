/* Checks the stability of the parameters as a set. Parameters are written one by one, each within its range; the set is
 * checked when the cooperation starts and before a save.
 *
 * Near the target, the error e obeys e' = -P K e, with P = J (J^T W J + D)^-1 J^T W and the damping D. P is similar to
 * a symmetric matrix with eigenvalues from 0 to 1. Therefore, in any posture, no error decays faster than exp(-k t),
 * where k is the largest gain of the components with nonzero weight. With a loop delay T, the loop is stable if k T is
 * below pi / 2; above about half of that, the error oscillates before it settles.
 *
 * A slow loop is never unstable, so gains, speed and acceleration have no lower bound here. */
#ifndef COMANIP_PARAMETER_SET_H
#define COMANIP_PARAMETER_SET_H

#include "parameters.h"

typedef enum {
    PARAMETER_SET_RESTS,     /* the arm comes to rest when the hand does */
    PARAMETER_SET_MAY_SWING, /* the arm may oscillate, because prediction is off or the paper's control law is used */
    PARAMETER_SET_UNSTABLE,  /* the arm does not come to rest, so starts and saves are refused */
} parameter_set_verdict_t;

typedef struct {
    parameter_set_verdict_t verdict;
    uint64_t involved; /* bit mask of the parameters that together cause the verdict */
} parameter_set_t;

/* Checks the parameters. tick_s: the control period, > 0. */
parameter_set_t parameter_set_check(const parameters_t *parameters, float tick_s);

#endif
