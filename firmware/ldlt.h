/* L D L^T of a symmetric positive definite matrix of up to ARM_MAX_JOINTS rows. */
#ifndef COMANIP_LDLT_H
#define COMANIP_LDLT_H

#include "arm.h"

typedef struct {
    float lower[ARM_MAX_JOINTS][ARM_MAX_JOINTS]; /* the matrix's lower triangle with its diagonal; factorised: L, below the diagonal */
    float inverse_pivot[ARM_MAX_JOINTS];         /* 1 / D */
} ldlt_t;

/* In place. A pivot that is not above 0 gets the inverse 0. */
void ldlt_factorise(ldlt_t *self, int n);

/* x: the right-hand side, then the solution. */
void ldlt_solve(const ldlt_t *self, int n, float x[]);

#endif
