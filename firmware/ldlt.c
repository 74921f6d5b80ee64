#include "ldlt.h"

void ldlt_factorise(ldlt_t *self, int n) {
    for (int i = 0; i < n; i++) {
        float *row = self->lower[i];
        for (int j = 0; j < i; j++) { /* first L D ... */
            for (int k = 0; k < j; k++) {
                row[j] -= row[k] * self->lower[j][k];
            }
        }
        float pivot = row[i];
        for (int j = 0; j < i; j++) { /* ... then L */
            float factor = row[j] * self->inverse_pivot[j];
            pivot -= row[j] * factor;
            row[j] = factor;
        }
        self->inverse_pivot[i] = pivot > 0.0f ? 1.0f / pivot : 0.0f;
    }
}

void ldlt_solve(const ldlt_t *self, int n, float x[]) {
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < i; j++) {
            x[i] -= self->lower[i][j] * x[j];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        x[i] *= self->inverse_pivot[i];
        for (int k = i + 1; k < n; k++) {
            x[i] -= self->lower[k][i] * x[k];
        }
    }
}
