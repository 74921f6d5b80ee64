/* L D L^T of a symmetric positive definite matrix of up to ARM_MAX_JOINTS rows. */
#ifndef COMANIP_LDLT_H
#define COMANIP_LDLT_H

#include "../arms/arm.h"

typedef struct {
    float matrix[ARM_MAX_JOINTS]
                [ARM_MAX_JOINTS]; /* upper triangle with the diagonal; when factorised also L, below the diagonal */
    float inverse_pivot[ARM_MAX_JOINTS]; /* 1 / D */
} ldlt_t;

/* 0 of a pivot that is not above 0, as rounding can make it. */
static inline float ldlt_inverse(float pivot) {
    return pivot > 0.0f ? 1.0f / pivot : 0.0f;
}

/* Of the upper triangle, which stays. */
void ldlt_factorise(ldlt_t *self, int n);

/* Rows, a bit each, that shall count with their columns as 0 but for the diagonal, from the next ldlt_factorise() on.
 */
void ldlt_leave_out(ldlt_t *self, int n, uint8_t rows);

/* x: the right-hand side, then the solution. */
void ldlt_solve(const ldlt_t *self, int n, float x[]);

#endif
