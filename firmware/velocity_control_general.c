#include "velocity_control_general.h"

#include <string.h>

#include "ldlt.h"

/* As parts of the largest diagonal of J^T W J: with less damping than the first, float32's rounding would decide what
 * happens at a singularity, and the second is used. */
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

/* Summed in pairs: three roundings deep instead of seven. */
static float dot8(const float a[8], const float b[8]) {
    return ((a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])) +
           ((a[4] * b[4] + a[5] * b[5]) + (a[6] * b[6] + a[7] * b[7]));
}

/* The transpose of multiplication by x from the left: <multiply(x, a), b> = <a, multiply_transposed(x, b)>. */
static dual_quaternion_t multiply_transposed(dual_quaternion_t x, dual_quaternion_t b) {
    const dual_quaternion_t conjugate = dual_quaternion_conjugate(x);
    return (dual_quaternion_t){
        quaternion_add(quaternion_multiply(conjugate.primary, b.primary), quaternion_multiply(conjugate.dual, b.dual)),
        quaternion_multiply(conjugate.primary, b.dual),
    };
}

/* J^T W e with J's columns hand * half_line. The product with the hand is taken once for all joints: its rounding is then
 * an error of e, which is harmless, where rounded columns would be an error of J, which damping of 1e-4 magnifies. */
static void project(int joint_count, dual_quaternion_t hand, const dual_quaternion_t half_line[], const float weight[8],
                    const float e[8], float projection[]) {
    float weighted[8];
    for (int k = 0; k < 8; k++) {
        weighted[k] = weight[k] * e[k];
    }
    float seen_from_hand[8];
    to_vec8(multiply_transposed(hand, from_vec8(weighted)), seen_from_hand);
    for (int i = 0; i < joint_count; i++) {
        float line[8];
        to_vec8(half_line[i], line);
        projection[i] = dot8(line, seen_from_hand);
    }
}

/* The hand, and half the joints' axes seen from it; zero for joints that are blocked. */
static dual_quaternion_t half_lines(const arm_t *arm, const velocity_request_t *request, dual_quaternion_t half_line[]) {
    arm_lines_t lines;
    arm_lines(arm, request->position_rad, &lines);
    for (int i = 0; i < arm->joint_count; i++) {
        const bool is_blocked = (request->blocked >> i & 1u) != 0u;
        half_line[i] = is_blocked ? (dual_quaternion_t){0} : arm_half_line(lines.axis[i], lines.moment_m[i]);
    }
    return pose_to_dual_quaternion(lines.hand);
}

void velocity_control_general(const arm_t *arm, const velocity_control_config_t *config,
                              const velocity_request_t *request, float velocity_radps[]) {
    const int joint_count = arm->joint_count;
    dual_quaternion_t half_line[ARM_MAX_JOINTS];
    dual_quaternion_t hand = half_lines(arm, request, half_line);
    dual_quaternion_t target = dual_quaternion_align(pose_to_dual_quaternion(*request->target), hand);
    if (config->error_frame == ERROR_FRAME_TARGET) { /* the same law with all poses seen from the target */
        hand = dual_quaternion_multiply(dual_quaternion_conjugate(target), hand);
        target = dual_quaternion_identity;
    }
    float wanted[8]; /* K e */
    to_vec8(dual_quaternion_add(target, dual_quaternion_negate(hand)), wanted);
    for (int k = 0; k < 8; k++) {
        wanted[k] *= config->gain_per_s[k];
    }

    /* (J^T W J + lambda I) u = J^T W K e; matrices by joint, so transposed */
    float jacobian[ARM_MAX_JOINTS][8];
    ldlt_t normal;
    float largest = 0.0f;
    for (int i = 0; i < joint_count; i++) {
        float weighted[8];
        to_vec8(dual_quaternion_multiply(hand, half_line[i]), jacobian[i]);
        for (int k = 0; k < 8; k++) {
            weighted[k] = jacobian[i][k] * config->weight[k];
        }
        for (int j = 0; j <= i; j++) {
            normal.lower[i][j] = dot8(weighted, jacobian[j]);
        }
        largest = normal.lower[i][i] > largest ? normal.lower[i][i] : largest;
    }
    bool too_little = config->damping < RELATIVE_DAMPING_MIN * largest;
    float damping = too_little ? RELATIVE_DAMPING_SAFE * largest : config->damping;
    for (int i = 0; i < joint_count; i++) {
        normal.lower[i][i] += damping;
    }
    ldlt_factorise(&normal, joint_count);
    project(joint_count, hand, half_line, config->weight, wanted, velocity_radps);
    ldlt_solve(&normal, joint_count, velocity_radps);

    /* One step of refinement, with the residual K e - J u: J^T W J has lost half of the digits where J is nearly
     * singular. */
    float motion[8] = {0.0f}; /* sum of half_line u, so that J u = hand * motion */
    for (int i = 0; i < joint_count; i++) {
        float line[8];
        to_vec8(half_line[i], line);
        for (int k = 0; k < 8; k++) {
            motion[k] += line[k] * velocity_radps[i];
        }
    }
    float reached[8];
    to_vec8(dual_quaternion_multiply(hand, from_vec8(motion)), reached);
    for (int k = 0; k < 8; k++) {
        wanted[k] -= reached[k];
    }
    float correction[ARM_MAX_JOINTS];
    project(joint_count, hand, half_line, config->weight, wanted, correction);
    for (int i = 0; i < joint_count; i++) {
        correction[i] -= damping * velocity_radps[i];
    }
    ldlt_solve(&normal, joint_count, correction);
    for (int i = 0; i < joint_count; i++) {
        velocity_radps[i] += correction[i];
    }
}
