/* Loops over arrays for Python: see batch.h. */
#include "batch.h"

void batch_multiply(size_t count, const dual_quaternion_t a[], const dual_quaternion_t b[], dual_quaternion_t out[]) {
    for (size_t row = 0; row < count; row++) {
        out[row] = dual_quaternion_multiply(a[row], b[row]);
    }
}

void batch_conjugate(size_t count, const dual_quaternion_t a[], dual_quaternion_t out[]) {
    for (size_t row = 0; row < count; row++) {
        out[row] = dual_quaternion_conjugate(a[row]);
    }
}

void batch_normalise(size_t count, const dual_quaternion_t a[], dual_quaternion_t out[]) {
    for (size_t row = 0; row < count; row++) {
        out[row] = dual_quaternion_normalise(a[row]);
    }
}

void batch_decompositional_multiply(size_t count, const dual_quaternion_t a[], const dual_quaternion_t b[],
                                    dual_quaternion_t out[]) {
    for (size_t row = 0; row < count; row++) {
        out[row] = dual_quaternion_decompositional_multiply(a[row], b[row]);
    }
}

void batch_pose_from_matrix(size_t count, const float matrix[], const vector3_t translation_m[],
                            dual_quaternion_t out[]) {
    for (size_t row = 0; row < count; row++) {
        out[row] = dual_quaternion_from_pose(quaternion_from_matrix(&matrix[9 * row]), translation_m[row]);
    }
}

void batch_forward_kinematics(const arm_t *arm, size_t count, const float position_rad[], dual_quaternion_t out[]) {
    for (size_t row = 0; row < count; row++) {
        out[row] = pose_to_dual_quaternion(arm->forward_kinematics(arm, &position_rad[row * arm->joint_count]));
    }
}

void batch_pose_jacobian(const arm_t *arm, size_t count, const float position_rad[], float out[]) {
    const size_t n = arm->joint_count;

    for (size_t row = 0; row < count; row++) {
        arm_jacobian_t geometric;
        float *jacobian = &out[row * 8 * n];

        arm_jacobian(arm, &position_rad[row * n], &geometric);
        const dual_quaternion_t hand = pose_to_dual_quaternion(geometric.end_effector);
        for (size_t joint = 0; joint < n; joint++) {
            const dual_quaternion_t column =
                dual_quaternion_multiply(hand, arm_half_twist(geometric.angular[joint], geometric.linear_m[joint]));
            const quaternion_t p = column.primary;
            const quaternion_t d = column.dual;
            const float vec8[8] = {p.w, p.x, p.y, p.z, d.w, d.x, d.y, d.z};

            for (size_t component = 0; component < 8; component++) {
                jacobian[component * n + joint] = vec8[component];
            }
        }
    }
}

void batch_joint_velocity(const arm_ik_t *ik, const differential_ik_config_t *config, size_t count,
                          const float position_rad[], const dual_quaternion_t target[], float out[]) {
    const size_t n = ik->arm->joint_count;

    for (size_t row = 0; row < count; row++) {
        const pose_t pose = pose_from_dual_quaternion(target[row]);

        const differential_ik_request_t request = {.position_rad = &position_rad[row * n], .target = &pose};

        arm_ik_differential(ik, config, &request, &out[row * n]);
    }
}
