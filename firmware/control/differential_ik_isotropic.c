/* Isotropic differential inverse kinematics: see differential_ik_isotropic.h. */
#include "differential_ik_isotropic.h"

#include "../maths/ldlt.h"

/* Equation (4) without vec8, for the case in which K and W each have one value for rotation and one for translation.
 *
 * Multiplying error and Jacobian by a unit quaternion, from the left or the right, is an orthogonal map of each half of
 * vec8. This map commutes with such K and W, so it changes neither J^T W J nor J^T W K e. Let x = r + eps 1/2 t r be
 * the end effector's pose, let x_d = r_d + eps 1/2 t_d r_d be the target, let l_i + eps m_i be the axis of joint i in
 * the end effector's frame, and let d = conj(r) r_d. The vector v' = conj(r) v r is v in the end effector's axes.
 *
 * Torso frame: e = x_d - x, J_i = x 1/2 (l_i + eps m_i). Multiplied by conj(r) from the left:
 *
 *     e -> d - 1 + eps 1/2 (t_d' d - t'),                  J_i -> 1/2 (l_i + eps (m_i + 1/2 t' l_i))
 *
 * Target frame: y = conj(x_d) x = conj(d) (1 + eps h) with h = 1/2 (t' - t_d'), e = 1 - y, J_i = y 1/2 (l_i + eps m_i).
 * Multiplied by d from the left:
 *
 *     e -> d - 1 - eps h,                                  J_i -> 1/2 (l_i + eps (m_i + h l_i))
 *
 * With g = -1/2 t' in the torso frame, and g = 1/2 (t_d' - t') in the target frame, both forms of J_i are equal to 1/2
 * (l_i + eps (l_i . g + m_i + l_i x g)), which consists of 7 numbers. Since l_i is a vector, only the vector part of d
 * matters.
 *
 * Therefore J_i^T W e equals 1/2 (w_r l_i . turn + w_t (l_i . g s + (m_i + l_i x g) . dual)), where `turn` is the
 * vector part of d, and s and `dual` are the scalar and the vector part of the error's dual part (s is 0 in the target
 * frame). Without the factor 1/2, this is l_i . (w_r turn + w_t s g) + w_t (m_i + l_i x g) . dual. */
typedef struct {
    vector3_t g;      /* [m] */
    vector3_t turn;   /* rotation error times pull_rotation, plus s g times pull_translation */
    vector3_t dual_m; /* translation error times pull_translation */
} pose_error_t;

static pose_error_t error_of(const pose_t *hand, const pose_t *target, const differential_ik_config_t *config) {
    const differential_ik_isotropic_t *law = &config->isotropic;
    const quaternion_t to_hand = quaternion_conjugate(hand->rotation);
    const quaternion_t d = quaternion_align(quaternion_multiply(to_hand, target->rotation), quaternion_identity);
    const vector3_t turn = vector3_scale((vector3_t){d.x, d.y, d.z}, law->pull_rotation);
    if (config->error_frame == ERROR_FRAME_TARGET) {
        const vector3_t way = vector3_add(target->translation_m, vector3_scale(hand->translation_m, -1.0f));
        const vector3_t g = quaternion_rotate(to_hand, vector3_scale(way, 0.5f));
        return (pose_error_t){g, turn, vector3_scale(g, law->pull_translation)};
    }
    const vector3_t half_t = vector3_scale(quaternion_rotate(to_hand, hand->translation_m), 0.5f);
    const vector3_t half_t_d = vector3_scale(quaternion_rotate(to_hand, target->translation_m), 0.5f);
    const quaternion_t moved = quaternion_multiply((quaternion_t){0.0f, half_t_d.x, half_t_d.y, half_t_d.z}, d);
    const vector3_t g = vector3_scale(half_t, -1.0f);
    return (pose_error_t){
        g,
        vector3_add(turn, vector3_scale(g, law->pull_translation * moved.w)),
        vector3_scale(vector3_add((vector3_t){moved.x, moved.y, moved.z}, g), law->pull_translation),
    };
}

static float dot(quaternion_t a, quaternion_t b) {
    return (a.w * b.w + a.x * b.x) + (a.y * b.y + a.z * b.z);
}

typedef struct {
    int joint_count;
    ldlt_t normal;
    float right_side[ARM_MAX_JOINTS];
} equations_t;

static void solve(void *equations, float velocity_radps[]) {
    equations_t *self = equations;
    for (int i = 0; i < self->joint_count; i++) {
        velocity_radps[i] = self->right_side[i];
    }
    ldlt_factorise(&self->normal, self->joint_count);
    ldlt_solve(&self->normal, self->joint_count, velocity_radps);
}

static void lock(void *equations, uint8_t joints) {
    equations_t *self = equations;
    ldlt_decouple(&self->normal, self->joint_count, joints);
    for (int i = 0; i < self->joint_count; i++) {
        self->right_side[i] = (joints >> i & 1) != 0 ? 0.0f : self->right_side[i];
    }
}

void differential_ik_isotropic(const arm_t *arm, const differential_ik_config_t *config,
                               const differential_ik_request_t *request, float velocity_radps[]) {
    const differential_ik_isotropic_t *law = &config->isotropic;
    const int joint_count = arm->joint_count;
    arm_jacobian_t jacobian;
    arm_jacobian(arm, request->position_rad, &jacobian);
    const pose_error_t error = error_of(&jacobian.end_effector, request->target, config);

    equations_t equations = {.joint_count = joint_count};
    quaternion_t moved[ARM_MAX_JOINTS]; /* dual parts of the columns */
    float trace = 0.0f;
    for (int i = 0; i < joint_count; i++) {
        const vector3_t axis = jacobian.angular[i];
        const vector3_t linear = vector3_add(jacobian.linear_m[i], vector3_cross(axis, error.g));
        moved[i] = (quaternion_t){vector3_dot(axis, error.g), linear.x, linear.y, linear.z};
        equations.right_side[i] = vector3_dot(axis, error.turn) + vector3_dot(linear, error.dual_m);
        for (int j = 0; j < i; j++) {
            equations.normal.matrix[j][i] =
                law->weight_rotation * vector3_dot(axis, jacobian.angular[j]) + dot(moved[i], moved[j]);
        }
        const float squared = dot(moved[i], moved[i]);
        equations.normal.matrix[i][i] = law->diagonal + squared;
        trace += squared;
    }
    if (!(trace <= law->trace_max)) {
        differential_ik_general(arm, config, request, velocity_radps);
        return;
    }
    joints_at_limit_solve(request->at_limit, joint_count, &equations, solve, lock, velocity_radps);
}
