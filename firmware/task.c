#include "task.h"

#define Q_X_PI {0.0f, 1.0f, 0.0f, 0.0f}
/* q(x, pi) q(z, pi/4) = (0, cos pi/8, -sin pi/8, 0) */
#define Q_X_PI_Q_Z_PI_4 {0.0f, 0.92387953251128674f, -0.38268343236508977f, 0.0f}

const task_t task_table[TASK_BUILT_IN_COUNT] = {
    [TASK_POUR] = {TASK_FORM_CONSTANT, {0.01f, 0.0f, -0.05f}, Q_X_PI_Q_Z_PI_4, Q_X_PI},
    [TASK_TELEOP] = {TASK_FORM_CONSTANT, {0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f, 0.0f}},
    [TASK_MIRROR] = {TASK_FORM_MIRRORED, {0.0f, 0.0f, 0.0f}, Q_X_PI, Q_X_PI},
};

dual_quaternion_t task_relation(const task_t *task, float forward_displacement_m) {
    vector3_t t = task->t_task_m;
    if (task->form == TASK_FORM_MIRRORED) {
        t.z += 2.0f * forward_displacement_m;
    }
    return dual_quaternion_from_pose(task->q_task, t);
}
