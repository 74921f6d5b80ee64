#include "position_priority.h"

#include "joint_ends.h"
#include "position_priority_terms.h"

/* All vectors are seen from the hand. */
typedef struct {
    vector3_t way_m;    /* e */
    vector3_t turn_rad; /* 2 v */
    float stiffness;    /* k */
    twist_t motion;
    float distance_m; /* without the cap */
} pose_error_t;

static pose_error_t error_of(const pose_t *hand, const position_priority_request_t *request) {
    const quaternion_t to_hand = quaternion_conjugate(hand->rotation);
    const vector3_t way_m = vector3_add(request->target->translation_m, vector3_scale(hand->translation_m, -1.0f));
    const float distance_m = __builtin_sqrtf(vector3_dot(way_m, way_m));
    const quaternion_t d =
        quaternion_align(quaternion_multiply(to_hand, request->target->rotation), quaternion_identity);
    const vector3_t turn_rad = {2.0f * d.x, 2.0f * d.y, 2.0f * d.z};
    return (pose_error_t){
        .way_m = quaternion_rotate(to_hand, vector3_scale(way_m, position_priority_share(distance_m))),
        .turn_rad = turn_rad,
        .stiffness = position_priority_stiffness(vector3_dot(turn_rad, turn_rad)),
        .motion = {quaternion_rotate(to_hand, request->motion->velocity_mps),
                   quaternion_rotate(to_hand, request->motion->angular_velocity_radps)},
        .distance_m = distance_m,
    };
}

typedef struct {
    float xx, xy, xz, yy, yz, zz;
} symmetric_t;

/* Task damping times (J_p J_p^T + floor I)^-1. */
static symmetric_t task_damping(const arm_jacobian_t *jacobian, int joint_count) {
    symmetric_t m = {POSITION_PRIORITY_TASK_FLOOR_M2, 0.0f, 0.0f,
                     POSITION_PRIORITY_TASK_FLOOR_M2, 0.0f, POSITION_PRIORITY_TASK_FLOOR_M2};
    for (int i = 0; i < joint_count; i++) {
        const vector3_t moment = jacobian->linear_m[i];
        m.xx += moment.x * moment.x;
        m.xy += moment.x * moment.y;
        m.xz += moment.x * moment.z;
        m.yy += moment.y * moment.y;
        m.yz += moment.y * moment.z;
        m.zz += moment.z * moment.z;
    }
    const symmetric_t cofactor = {
        m.yy * m.zz - m.yz * m.yz, m.xz * m.yz - m.xy * m.zz, m.xy * m.yz - m.xz * m.yy,
        m.xx * m.zz - m.xz * m.xz, m.xy * m.xz - m.xx * m.yz, m.xx * m.yy - m.xy * m.xy,
    };
    const float determinant = m.xx * cofactor.xx + m.xy * cofactor.xy + m.xz * cofactor.xz;
    const float scale = position_priority_task_scale(determinant, m.xx + m.yy + m.zz);
    return (symmetric_t){scale * cofactor.xx, scale * cofactor.xy, scale * cofactor.xz,
                         scale * cofactor.yy, scale * cofactor.yz, scale * cofactor.zz};
}

static vector3_t times(const symmetric_t *m, vector3_t v) {
    return (vector3_t){m->xx * v.x + m->xy * v.y + m->xz * v.z, m->xy * v.x + m->yy * v.y + m->yz * v.z,
                       m->xz * v.x + m->yz * v.y + m->zz * v.z};
}

static void set_up(position_priority_equations_t *self, const arm_t *arm, const position_priority_config_t *config,
                   const float position_rad[], const arm_jacobian_t *jacobian, const pose_error_t *error) {
    const float weight = config->orientation_weight_m2;
    const symmetric_t damping = task_damping(jacobian, arm->joint_count);
    float diagonal[ARM_MAX_JOINTS];
    for (int i = 0; i < arm->joint_count; i++) {
        const vector3_t axis = jacobian->angular[i], moment = jacobian->linear_m[i];
        const vector3_t damped = vector3_add(moment, times(&damping, moment));
        const float way_out_rad = position_priority_out_of_margin(&arm->joints[i], position_rad[i]);
        const float turn = vector3_dot(axis, error->turn_rad) + error->stiffness * way_out_rad;
        self->error[i] = config->gain_per_s * (vector3_dot(moment, error->way_m) + weight * turn);
        self->motion[i] = vector3_dot(moment, error->motion.velocity_mps) +
                          weight * vector3_dot(axis, error->motion.angular_velocity_radps);
        diagonal[i] = position_priority_damping(weight * error->stiffness, way_out_rad);
        for (int j = 0; j <= i; j++) {
            self->normal.matrix[j][i] =
                vector3_dot(damped, jacobian->linear_m[j]) + weight * vector3_dot(axis, jacobian->angular[j]);
            const float curvature_m2 = vector3_dot(vector3_cross(jacobian->angular[j], error->way_m), moment);
            const float share_m2 = POSITION_PRIORITY_CURVATURE_SHARE * __builtin_fabsf(curvature_m2);
            diagonal[i] += share_m2;
            diagonal[j] += j != i ? share_m2 : 0.0f;
        }
    }
    for (int i = 0; i < arm->joint_count; i++) {
        self->normal.matrix[i][i] += diagonal[i];
    }
}

/* joints, a bit each, stand still. */
static void leave_out(position_priority_equations_t *self, int joint_count, uint8_t joints) {
    ldlt_leave_out(&self->normal, joint_count, joints);
    for (int i = 0; i < joint_count; i++) {
        if ((joints >> i & 1) != 0) {
            self->error[i] = 0.0f;
            self->motion[i] = 0.0f;
        }
    }
}

void position_priority_solve(position_priority_equations_t *equations, int joint_count, joint_ends_t ends,
                             float feedback_radps[], float feedforward_radps[]) {
    uint8_t out = 0;
    for (;;) {
        float sum_radps[ARM_MAX_JOINTS];
        for (int i = 0; i < joint_count; i++) {
            feedback_radps[i] = equations->error[i];
            feedforward_radps[i] = equations->motion[i];
        }
        ldlt_factorise(&equations->normal, joint_count);
        ldlt_solve(&equations->normal, joint_count, feedback_radps);
        ldlt_solve(&equations->normal, joint_count, feedforward_radps);
        for (int i = 0; i < joint_count; i++) {
            sum_radps[i] = feedback_radps[i] + feedforward_radps[i];
        }
        const uint8_t more = joint_ends_leave_out(ends, joint_count, sum_radps, &out);
        if (more == 0u) {
            return;
        }
        leave_out(equations, joint_count, more);
    }
}

float position_priority(const arm_t *arm, const position_priority_config_t *config,
                        const position_priority_request_t *request, float feedback_radps[], float feedforward_radps[]) {
    arm_jacobian_t jacobian;
    arm_jacobian(arm, request->position_rad, &jacobian);
    const pose_error_t error = error_of(&jacobian.end_effector, request);
    position_priority_equations_t equations;
    set_up(&equations, arm, config, request->position_rad, &jacobian, &error);
    position_priority_solve(&equations, arm->joint_count, request->ends, feedback_radps, feedforward_radps);
    return error.distance_m;
}
