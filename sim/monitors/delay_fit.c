#include "delay_fit.h"

#include <math.h>
#include <string.h>

#include "../common/solve_3x3.h"

#define DAMPING_PER_SAMPLE 1e-4 /* keeps k small unless the hand rotates by more than about 0.01 rad */

static void add_follower(delay_sums_t *sums, size_t follower, const double at_m[3], const delay_hand_t *hand) {
    double fitted_m[3];
    for (size_t k = 0; k < 3; k++) {
        fitted_m[k] = at_m[k] - hand->scaled_hand_m[k];
        sums->follower[follower].fitted_m[k] += fitted_m[k];
        sums->follower[follower].square_m2 += fitted_m[k] * fitted_m[k];
    }
    for (size_t k = 0; k < 3; k++) {
        sums->follower[follower].rotated_m[k] +=
            hand->turn[0][k] * fitted_m[0] + hand->turn[1][k] * fitted_m[1] + hand->turn[2][k] * fitted_m[2];
    }
}

void delay_fit_add(delay_fit_t *self, double follower_m[DELAY_FOLLOWERS][3], const delay_hand_t *hand[DELAY_COUNT]) {
    self->samples++;
    for (size_t n = 0; n < DELAY_COUNT; n++) {
        delay_sums_t *sums = &self->sums[n];
        for (size_t i = 0; i < 3; i++) {
            for (size_t k = 0; k < 3; k++) {
                sums->turn[i][k] += hand[n]->turn[i][k];
            }
        }
        for (size_t f = 0; f < DELAY_FOLLOWERS; f++) {
            add_follower(sums, f, follower_m[f], hand[n]);
        }
    }
}

/* Returns the minimum over k and b of the sum of |fitted - R k - b|^2, where fitted = follower - s h. Eliminating
 * b = mean(fitted - R k) leaves three linear equations for k. */
static double residual_m2(const delay_fit_t *self, const delay_sums_t *sums, size_t follower) {
    const double count = (double)self->samples;
    const double *fitted_m = sums->follower[follower].fitted_m;
    double a[3][3], right_m[3], lever_m[3];
    double left = sums->follower[follower].square_m2;
    for (size_t i = 0; i < 3; i++) {
        right_m[i] = sums->follower[follower].rotated_m[i];
        for (size_t k = 0; k < 3; k++) {
            right_m[i] -= sums->turn[k][i] * fitted_m[k] / count;
            a[i][k] = i == k ? count : 0.0;
            for (size_t row = 0; row < 3; row++) {
                a[i][k] -= sums->turn[row][i] * sums->turn[row][k] / count;
            }
        }
    }
    solve_3x3(a, DAMPING_PER_SAMPLE * count, right_m, lever_m);
    for (size_t k = 0; k < 3; k++) {
        left -= fitted_m[k] * fitted_m[k] / count + right_m[k] * lever_m[k];
    }
    return left;
}

void delay_fit_end_stretch(delay_fit_t *self) {
    if (self->samples == 0) {
        return;
    }
    for (size_t n = 0; n < DELAY_COUNT; n++) {
        for (size_t f = 0; f < DELAY_FOLLOWERS; f++) {
            self->residual_m2[n][f] += residual_m2(self, &self->sums[n], f);
        }
    }
    self->samples = 0;
    memset(self->sums, 0, sizeof self->sums);
}

double delay_fit_ms(const delay_fit_t *self, delay_follower_t follower) {
    size_t best = 0;
    for (size_t n = 1; n < DELAY_COUNT; n++) {
        best = self->residual_m2[n][follower] < self->residual_m2[best][follower] ? n : best;
    }
    if (best == 0 || best == DELAY_COUNT - 1) {
        return (double)NAN;
    }
    /* Refine the delay: take the minimum of the parabola through the best point and its two neighbours. */
    const double before = self->residual_m2[best - 1][follower], at = self->residual_m2[best][follower];
    const double after = self->residual_m2[best + 1][follower];
    const double bend = before - 2.0 * at + after;
    const double share = bend > 0.0 ? 0.5 * (before - after) / bend : 0.0;
    return DELAY_FIRST_TICKS + DELAY_STEP_TICKS * ((double)best + share);
}
