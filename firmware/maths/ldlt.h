/* L D L^T factorisation of a symmetric positive definite matrix, and the solution of equations with it. */
#ifndef COMANIP_LDLT_H
#define COMANIP_LDLT_H

#include <stdint.h>

#define LDLT_MAX_ROWS 8

typedef struct {
    float matrix[LDLT_MAX_ROWS][LDLT_MAX_ROWS]; /* the upper triangle with the diagonal; below it, once factorised, L */
    float inverse_pivot[LDLT_MAX_ROWS];         /* 1 / D */
} ldlt_t;

/* 1 / pivot, or 0 if the pivot is not above 0, as rounding can make it. */
static inline float ldlt_inverse(float pivot) {
    return pivot > 0.0f ? 1.0f / pivot : 0.0f;
}

/* Factorises the upper triangle, and keeps it. n: rows, at most LDLT_MAX_ROWS, in all of these. */
void ldlt_factorise(ldlt_t *self, int n);

/* rows: a bit mask. Sets these rows and columns to 0 but for their diagonal elements; ldlt_factorise() is due next. */
void ldlt_decouple(ldlt_t *self, int n, uint8_t rows);

/* x: the right-hand side, then the solution. */
void ldlt_solve(const ldlt_t *self, int n, float x[]);

#endif
