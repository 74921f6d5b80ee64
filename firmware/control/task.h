/* A cooperative task is the pose of the person's hand relative to the end effector (equation (1), Table I). */
#ifndef COMANIP_TASK_H
#define COMANIP_TASK_H

#include <stdint.h>

#include "../maths/pose.h"
#include "../protocol/messages.h"
#include "comanip_tasks.h"

typedef struct {
    task_form_t form;
    vector3_t t_task_m;  /* translation of q_task, in the end effector's frame */
    quaternion_t q_task; /* rotation of q_task, unit */
    quaternion_t q_inv;  /* unit: rotation from the end effector to the virtual hand at the start */
} task_t;

/* The built-in tasks of Table I, indexed by task_id_t. The entries of TASK_CUSTOM and of unused numbers are zero. */
extern const task_t task_table[COMANIP_TASK_NUMBERS];

/* Returns the built-in task with this number, or NULL. */
const task_t *task_built_in(uint8_t number);

/* q_task as a function of the hand's displacement along the torso's x axis since the start. `slope` times this
 * displacement is added to the z component of the translation of `pose`. */
typedef struct {
    pose_t pose;
    float slope; /* 0: constant */
} task_relation_t;

task_relation_t task_relation(const task_t *task);

/* Returns the q_task of equation (2) at this displacement. */
pose_t task_relation_at(const task_relation_t *relation, float forward_displacement_m);

/* Interpolates from a (s = 0) to b (s = 1) like pose_interpolate(). */
task_relation_t task_relation_interpolate(const task_relation_t *a, const task_relation_t *b, float s);

#endif
