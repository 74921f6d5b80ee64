/* L D L^T factorisation: see ldlt.h. */
#include "ldlt.h"

void ldlt_factorise(ldlt_t *self, int n) {
    for (int i = 0; i < n; i++) {
        float *row = self->matrix[i];
        for (int j = 0; j < i; j++) { /* row i of L D */
            const float *factor = self->matrix[j];
            float rest = factor[i];
            for (int k = 0; k < j; k++) {
                rest -= row[k] * factor[k];
            }
            row[j] = rest;
        }
        float pivot = row[i];
        for (int j = 0; j < i; j++) { /* row i of L */
            const float factor = row[j] * self->inverse_pivot[j];
            pivot -= row[j] * factor;
            row[j] = factor;
        }
        self->inverse_pivot[i] = ldlt_inverse(pivot);
    }
}

void ldlt_decouple(ldlt_t *self, int n, uint8_t rows) {
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < i; j++) {
            if (((rows >> i | rows >> j) & 1) != 0) {
                self->matrix[j][i] = 0.0f;
            }
        }
    }
}

void ldlt_solve(const ldlt_t *self, int n, float x[]) {
    for (int i = 0; i < n; i++) {
        const float *factor = self->matrix[i];
        float rest = x[i];
        for (int j = 0; j < i; j++) {
            rest -= factor[j] * x[j];
        }
        x[i] = rest;
    }
    for (int i = n - 1; i >= 0; i--) {
        float rest = x[i] * self->inverse_pivot[i];
        for (int k = i + 1; k < n; k++) {
            rest -= self->matrix[k][i] * x[k];
        }
        x[i] = rest;
    }
}
