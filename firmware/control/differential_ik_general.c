/* Differential inverse kinematics for any K, W and damping: see differential_ik.h. */
#include "differential_ik.h"

#include <string.h>

#include "../maths/ldlt.h"

/* Damping, relative to the largest diagonal element of J^T W J. Below the minimum, float32's rounding would dominate at
 * a singularity, so the safe value is used instead. */
#define RELATIVE_DAMPING_MIN 2.5e-7f
#define RELATIVE_DAMPING_SAFE 2e-6f

static void to_vec8(dual_quaternion_t x, float vec8[8]) {
    memcpy(vec8, &x, sizeof x);
}

static dual_quaternion_t from_vec8(const float vec8[8]) {
    dual_quaternion_t x;
    memcpy(&x, vec8, sizeof x);
    return x;
}

/* Returns the dot product. The products are summed in pairs, so that each of them passes through only three rounded
 * additions instead of up to seven. */
static float dot8(const float a[8], const float b[8]) {
    return ((a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])) +
           ((a[4] * b[4] + a[5] * b[5]) + (a[6] * b[6] + a[7] * b[7]));
}

/* Applies the transpose of left multiplication by x: <multiply(x, a), b> = <a, multiply_transposed(x, b)>. */
static dual_quaternion_t multiply_transposed(dual_quaternion_t x, dual_quaternion_t b) {
    const dual_quaternion_t conjugate = dual_quaternion_conjugate(x);
    return (dual_quaternion_t){
        quaternion_add(quaternion_multiply(conjugate.primary, b.primary), quaternion_multiply(conjugate.dual, b.dual)),
        quaternion_multiply(conjugate.primary, b.dual),
    };
}

/* The equations (J^T W J + damping I) u = J^T W desired. */
typedef struct {
    int joint_count;
    dual_quaternion_t hand;
    /* The joints' axes in the end effector's frame, multiplied by 1/2. Column i of J is hand * half_line[i]. */
    dual_quaternion_t half_line[ARM_MAX_JOINTS];
    const float *weight;
    float desired[8]; /* K e */
    float damping;
    ldlt_t normal;
} equations_t;

/* Computes J^T W e. The product with `hand` is computed once for all joints, so that its rounding error acts like an
 * error in e, which is harmless. If each column of J were rounded instead, the rounding errors would act like errors in
 * J, and a damping as small as 1e-4 would amplify them. */
static void project(const equations_t *self, const float e[8], float projection[]) {
    float weighted[8];
    for (int k = 0; k < 8; k++) {
        weighted[k] = self->weight[k] * e[k];
    }
    float seen_from_hand[8];
    to_vec8(multiply_transposed(self->hand, from_vec8(weighted)), seen_from_hand);
    for (int i = 0; i < self->joint_count; i++) {
        float line[8];
        to_vec8(self->half_line[i], line);
        projection[i] = dot8(line, seen_from_hand);
    }
}

/* Computes desired - J u. */
static void residual(const equations_t *self, const float u[], float rest[8]) {
    float motion[8] = {0.0f}; /* sum of half_line u, so that J u = hand * motion */
    for (int i = 0; i < self->joint_count; i++) {
        float line[8];
        to_vec8(self->half_line[i], line);
        for (int k = 0; k < 8; k++) {
            motion[k] += line[k] * u[i];
        }
    }
    float reached[8];
    to_vec8(dual_quaternion_multiply(self->hand, from_vec8(motion)), reached);
    for (int k = 0; k < 8; k++) {
        rest[k] = self->desired[k] - reached[k];
    }
}

static void solve(void *equations, float u[]) {
    equations_t *self = equations;
    ldlt_factorise(&self->normal, self->joint_count);
    project(self, self->desired, u);
    ldlt_solve(&self->normal, self->joint_count, u);

    /* One step of iterative refinement, because forming J^T W J loses half of the digits near a singularity. */
    float rest[8], correction[ARM_MAX_JOINTS];
    residual(self, u, rest);
    project(self, rest, correction);
    for (int i = 0; i < self->joint_count; i++) {
        correction[i] -= self->damping * u[i];
    }
    ldlt_solve(&self->normal, self->joint_count, correction);
    for (int i = 0; i < self->joint_count; i++) {
        u[i] += correction[i];
    }
}

static void lock(void *equations, uint8_t joints) {
    equations_t *self = equations;
    ldlt_decouple(&self->normal, self->joint_count, joints);
    for (int i = 0; i < self->joint_count; i++) {
        if ((joints >> i & 1) != 0) {
            self->half_line[i] = (dual_quaternion_t){0};
        }
    }
}

static void set_hand(equations_t *self, const arm_t *arm, const float position_rad[]) {
    arm_jacobian_t jacobian;
    arm_jacobian(arm, position_rad, &jacobian);
    for (int i = 0; i < arm->joint_count; i++) {
        self->half_line[i] = arm_half_twist(jacobian.angular[i], jacobian.linear_m[i]);
    }
    self->hand = pose_to_dual_quaternion(jacobian.end_effector);
}

static void set_desired(equations_t *self, const differential_ik_config_t *config, const pose_t *target_pose) {
    dual_quaternion_t target = dual_quaternion_align(pose_to_dual_quaternion(*target_pose), self->hand);
    if (config->error_frame == ERROR_FRAME_TARGET) {
        /* Express all poses in the target's frame. The Jacobian thereby becomes conj(q_d) J. */
        self->hand = dual_quaternion_multiply(dual_quaternion_conjugate(target), self->hand);
        target = dual_quaternion_identity;
    }
    to_vec8(dual_quaternion_add(target, dual_quaternion_negate(self->hand)), self->desired);
    for (int k = 0; k < 8; k++) {
        self->desired[k] *= config->gain_per_s[k];
    }
}

static void set_normal(equations_t *self, const differential_ik_config_t *config) {
    float jacobian[ARM_MAX_JOINTS][8]; /* transposed Jacobian: one row per joint */
    float largest = 0.0f;
    for (int i = 0; i < self->joint_count; i++) {
        float weighted[8];
        to_vec8(dual_quaternion_multiply(self->hand, self->half_line[i]), jacobian[i]);
        for (int k = 0; k < 8; k++) {
            weighted[k] = jacobian[i][k] * config->weight[k];
        }
        for (int j = 0; j <= i; j++) {
            self->normal.matrix[j][i] = dot8(weighted, jacobian[j]);
        }
        largest = self->normal.matrix[i][i] > largest ? self->normal.matrix[i][i] : largest;
    }
    const bool too_little = config->damping < RELATIVE_DAMPING_MIN * largest;
    self->damping = too_little ? RELATIVE_DAMPING_SAFE * largest : config->damping;
    for (int i = 0; i < self->joint_count; i++) {
        self->normal.matrix[i][i] += self->damping;
    }
}

void differential_ik_general(const arm_t *arm, const differential_ik_config_t *config,
                             const differential_ik_request_t *request, float velocity_radps[]) {
    equations_t equations;
    equations.joint_count = arm->joint_count;
    equations.weight = config->weight;
    set_hand(&equations, arm, request->position_rad);
    set_desired(&equations, config, request->target);
    set_normal(&equations, config);
    joints_at_limit_solve(request->at_limit, arm->joint_count, &equations, solve, lock, velocity_radps);
}
