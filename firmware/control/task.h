/* A cooperative task is the pose of the person's hand relative to the end effector (equation (1), Table I). */
#ifndef COMANIP_TASK_H
#define COMANIP_TASK_H

#include <stdint.h>

#include "../maths/pose.h"
#include "../protocol/messages.h"
#include "comanip_tasks.h"

typedef struct {
    task_form_t form;
    vector3_t t_task_m;  /* in the end effector's frame */
    quaternion_t q_task; /* unit */
    quaternion_t q_inv;  /* unit: rotation from end effector to virtual hand at the start */
} task_t;

/* The built-in tasks of Table I, indexed by task_id_t. TASK_CUSTOM and unused numbers have zeros. */
extern const task_t task_table[COMANIP_TASK_NUMBERS];

/* The built-in task with this number, or NULL. */
const task_t *task_built_in(uint8_t number);

/* q_task as a function of the person's hand: its displacement along the torso's x axis since the start, times `slope`,
 * is added to the translation along z. */
typedef struct {
    pose_t pose;
    float slope; /* 0: constant */
} task_relation_t;

task_relation_t task_relation(const task_t *task);

/* Equation (2): q_task at this displacement. */
pose_t task_relation_at(const task_relation_t *relation, float forward_displacement_m);

/* Interpolates from a (s = 0) to b (s = 1) like pose_interpolate(). */
task_relation_t task_relation_interpolate(const task_relation_t *a, const task_relation_t *b, float s);

#endif
