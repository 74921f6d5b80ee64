#include "task.h"

#define Q_X_PI {0.0f, 1.0f, 0.0f, 0.0f}
/* q(x, pi) q(z, pi/4) = (0, cos pi/8, -sin pi/8, 0) */
#define Q_X_PI_Q_Z_PI_4 {0.0f, 0.92387953251128674f, -0.38268343236508977f, 0.0f}

const task_t task_table[TASK_BUILT_IN_COUNT] = {
    [TASK_POUR] = {TASK_FORM_CONSTANT, {0.01f, 0.0f, -0.05f}, Q_X_PI_Q_Z_PI_4, Q_X_PI},
    [TASK_TELEOP] = {TASK_FORM_CONSTANT, {0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f, 0.0f}},
    [TASK_MIRROR] = {TASK_FORM_MIRRORED, {0.0f, 0.0f, 0.0f}, Q_X_PI, Q_X_PI},
};

task_relation_t task_relation(const task_t *task) {
    return (task_relation_t){{task->q_task, task->t_task_m}, task->form == TASK_FORM_MIRRORED ? 2.0f : 0.0f};
}

pose_t task_relation_at(const task_relation_t *relation, float forward_displacement_m) {
    pose_t pose = relation->pose;
    pose.translation_m.z += relation->slope * forward_displacement_m;
    return pose;
}

task_relation_t task_relation_interpolate(const task_relation_t *a, const task_relation_t *b, float s) {
    return (task_relation_t){pose_interpolate(a->pose, b->pose, s), a->slope + s * (b->slope - a->slope)};
}
