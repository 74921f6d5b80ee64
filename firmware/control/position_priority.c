/* Position-priority differential inverse kinematics for any arm: see position_priority.h. */
#include "position_priority.h"

#include "position_priority_terms.h"

/* All vectors are in the end effector's frame. */
typedef struct {
    vector3_t position_m; /* e */
    vector3_t turn_rad;   /* 2 v */
    float stiffness;      /* k */
    twist_t motion;
    float distance_m; /* |p| */
} pose_error_t;

static pose_error_t error_of(const pose_t *end_effector, const position_priority_request_t *request) {
    const quaternion_t to_end_effector = quaternion_conjugate(end_effector->rotation);
    const vector3_t error_m =
        vector3_add(request->target->translation_m, vector3_scale(end_effector->translation_m, -1.0f));
    const float distance_m = __builtin_sqrtf(vector3_dot(error_m, error_m));
    const quaternion_t d =
        quaternion_align(quaternion_multiply(to_end_effector, request->target->rotation), quaternion_identity);
    const vector3_t turn_rad = {2.0f * d.x, 2.0f * d.y, 2.0f * d.z};
    return (pose_error_t){
        .position_m = quaternion_rotate(to_end_effector, vector3_scale(error_m, position_priority_share(distance_m))),
        .turn_rad = turn_rad,
        .stiffness = position_priority_stiffness(vector3_dot(turn_rad, turn_rad)),
        .motion = {quaternion_rotate(to_end_effector, request->motion->velocity_mps),
                   quaternion_rotate(to_end_effector, request->motion->angular_velocity_radps)},
        .distance_m = distance_m,
    };
}

typedef struct {
    float xx, xy, xz, yy, yz, zz;
} symmetric_t;

/* Returns A - I. */
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
        const float within_rad =
            position_priority_margin(arm->joints[i].position_min_rad, arm->joints[i].position_max_rad, position_rad[i]);
        const float turn = vector3_dot(axis, error->turn_rad) + error->stiffness * within_rad;
        self->feedback[i] = config->gain_per_s * (vector3_dot(moment, error->position_m) + weight * turn);
        self->feedforward[i] = vector3_dot(moment, error->motion.velocity_mps) +
                               weight * vector3_dot(axis, error->motion.angular_velocity_radps);
        diagonal[i] = position_priority_damping(weight * error->stiffness, within_rad);
        for (int j = 0; j <= i; j++) {
            self->normal.matrix[j][i] =
                vector3_dot(damped, jacobian->linear_m[j]) + weight * vector3_dot(axis, jacobian->angular[j]);
            const float curvature_m2 = vector3_dot(vector3_cross(jacobian->angular[j], error->position_m), moment);
            const float share_m2 = POSITION_PRIORITY_CURVATURE_SHARE * __builtin_fabsf(curvature_m2);
            diagonal[i] += share_m2;
            diagonal[j] += j != i ? share_m2 : 0.0f;
        }
    }
    for (int i = 0; i < arm->joint_count; i++) {
        self->normal.matrix[i][i] += diagonal[i];
    }
}

/* The equations, and the arrays for their two solutions. */
typedef struct {
    position_priority_equations_t *equations;
    int joint_count;
    float *feedback_radps, *feedforward_radps;
} system_t;

static void solve(void *system, float velocity_radps[]) {
    system_t *self = system;
    for (int i = 0; i < self->joint_count; i++) {
        self->feedback_radps[i] = self->equations->feedback[i];
        self->feedforward_radps[i] = self->equations->feedforward[i];
    }
    ldlt_factorise(&self->equations->normal, self->joint_count);
    ldlt_solve(&self->equations->normal, self->joint_count, self->feedback_radps);
    ldlt_solve(&self->equations->normal, self->joint_count, self->feedforward_radps);
    for (int i = 0; i < self->joint_count; i++) {
        velocity_radps[i] = self->feedback_radps[i] + self->feedforward_radps[i];
    }
}

static void lock(void *system, uint8_t joints) {
    system_t *self = system;
    ldlt_decouple(&self->equations->normal, self->joint_count, joints);
    for (int i = 0; i < self->joint_count; i++) {
        if ((joints >> i & 1) != 0) {
            self->equations->feedback[i] = 0.0f;
            self->equations->feedforward[i] = 0.0f;
        }
    }
}

void position_priority_solve(position_priority_equations_t *equations, int joint_count, joints_at_limit_t at_limit,
                             float feedback_radps[], float feedforward_radps[]) {
    system_t system = {equations, joint_count, feedback_radps, feedforward_radps};
    float velocity_radps[ARM_MAX_JOINTS];
    joints_at_limit_solve(at_limit, joint_count, &system, solve, lock, velocity_radps);
}

float position_priority(const arm_t *arm, const position_priority_config_t *config,
                        const position_priority_request_t *request, float feedback_radps[], float feedforward_radps[]) {
    arm_jacobian_t jacobian;
    arm_jacobian(arm, request->position_rad, &jacobian);
    const pose_error_t error = error_of(&jacobian.end_effector, request);
    position_priority_equations_t equations;
    set_up(&equations, arm, config, request->position_rad, &jacobian, &error);
    position_priority_solve(&equations, arm->joint_count, request->at_limit, feedback_radps, feedforward_radps);
    return error.distance_m;
}
