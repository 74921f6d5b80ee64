/* The built-in tasks and their relations: see task.h. */
#include "task.h"

#include <stddef.h>

#define BRACES(...) {__VA_ARGS__}
#define ROW(NAME, number, name, form, t_task, q_task, q_inv)                                                           \
    [number] = {TASK_FORM_##form, BRACES t_task, BRACES q_task, BRACES q_inv},
const task_t task_table[COMANIP_TASK_NUMBERS] = {COMANIP_TASKS(ROW)};

const task_t *task_built_in(uint8_t number) {
#define CASE(NAME, number, name, form, t_task, q_task, q_inv) case number:
    switch (number) {
        COMANIP_TASKS(CASE)
        return &task_table[number];
    default: return NULL;
    }
}

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
