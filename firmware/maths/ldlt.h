/* Factorises a symmetric positive definite matrix as L D L^T, and solves linear equations with it. */
#ifndef COMANIP_LDLT_H
#define COMANIP_LDLT_H

#include <stdint.h>

#define LDLT_MAX_ROWS 8

typedef struct {
    float matrix[LDLT_MAX_ROWS][LDLT_MAX_ROWS]; /* the matrix on and above the diagonal; L below it, once factorised */
    float inverse_pivot[LDLT_MAX_ROWS];         /* 1 / D */
} ldlt_t;

/* Returns 1 / pivot, or 0 if rounding has made the pivot 0 or negative. */
static inline float ldlt_inverse(float pivot) {
    return pivot > 0.0f ? 1.0f / pivot : 0.0f;
}

/* Factorises the matrix in the upper triangle, which remains unchanged. In all functions, n is the number of rows, at
 * most LDLT_MAX_ROWS. */
void ldlt_factorise(ldlt_t *self, int n);

/* Sets the off-diagonal elements of these rows and columns to 0. rows: bit mask. Call ldlt_factorise() afterwards. */
void ldlt_decouple(ldlt_t *self, int n, uint8_t rows);

/* Solves the equations. x: the right-hand side, overwritten by the solution. */
void ldlt_solve(const ldlt_t *self, int n, float x[]);

#endif
