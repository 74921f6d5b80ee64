#include "velocity_control.h"

#include <string.h>

/* The least damping, as a part of the largest diagonal of J^T W J: below it, float32's rounding would decide what happens
 * at a singularity. */
#define RELATIVE_DAMPING_MIN 2e-6f

static void to_vec8(dual_quaternion_t x, float vec8[8]) {
    memcpy(vec8, &x, sizeof x);
}

/* Solves (A + damping I) u = b in place by LDL^T; A symmetric positive semidefinite, lower triangle used. A = 0 without
 * damping gives 0. */
static void solve_damped(int n, float a[ARM_MAX_JOINTS][ARM_MAX_JOINTS], float b[], float damping) {
    float largest = 0.0f;
    for (int i = 0; i < n; i++) {
        largest = a[i][i] > largest ? a[i][i] : largest;
    }
    const float damping_min = RELATIVE_DAMPING_MIN * largest;
    for (int i = 0; i < n; i++) {
        a[i][i] += damping > damping_min ? damping : damping_min;
    }
    float inverse_pivot[ARM_MAX_JOINTS];

    /* below the diagonal, row i: first L D (the products), then L */
    for (int i = 0; i < n; i++) {
        float pivot = a[i][i];
        for (int j = 0; j < i; j++) {
            float product = a[i][j];
            for (int k = 0; k < j; k++) {
                product -= a[i][k] * a[j][k];
            }
            a[i][j] = product;
        }
        for (int j = 0; j < i; j++) {
            float factor = a[i][j] * inverse_pivot[j];
            pivot -= a[i][j] * factor;
            a[i][j] = factor;
        }
        inverse_pivot[i] = pivot > 0.0f ? 1.0f / pivot : 0.0f;
        for (int j = 0; j < i; j++) {
            b[i] -= a[i][j] * b[j];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        b[i] *= inverse_pivot[i];
        for (int k = i + 1; k < n; k++) {
            b[i] -= a[k][i] * b[k];
        }
    }
}

void velocity_control(const velocity_control_config_t *config, int joint_count, const dual_quaternion_t column[],
                      dual_quaternion_t hand, dual_quaternion_t target, float velocity_radps[]) {
    target = dual_quaternion_align(target, hand);
    dual_quaternion_t error = dual_quaternion_add(target, dual_quaternion_negate(hand));
    float e[8];
    float jacobian[ARM_MAX_JOINTS][8]; /* transposed: one joint a row */
    if (config->error_frame == ERROR_FRAME_TARGET) {
        dual_quaternion_t to_target = dual_quaternion_conjugate(target);
        to_vec8(dual_quaternion_multiply(to_target, error), e); /* = 1 - conj(q_d) q */
        for (int i = 0; i < joint_count; i++) {
            to_vec8(dual_quaternion_multiply(to_target, column[i]), jacobian[i]);
        }
    } else {
        to_vec8(error, e);
        for (int i = 0; i < joint_count; i++) {
            to_vec8(column[i], jacobian[i]);
        }
    }

    float normal[ARM_MAX_JOINTS][ARM_MAX_JOINTS];
    for (int i = 0; i < joint_count; i++) {
        float weighted[8];
        float right = 0.0f;
        for (int k = 0; k < 8; k++) {
            weighted[k] = jacobian[i][k] * config->weight[k];
            right += weighted[k] * (config->gain_per_s[k] * e[k]);
        }
        velocity_radps[i] = right;
        for (int j = 0; j <= i; j++) {
            float product = 0.0f;
            for (int k = 0; k < 8; k++) {
                product += weighted[k] * jacobian[j][k];
            }
            normal[i][j] = product;
        }
    }
    solve_damped(joint_count, normal, velocity_radps, config->damping);
}
