/* A cooperative task is the relative pose of the human's hand seen from the robot's hand (equation (1), Table I). */
#ifndef COMANIP_TASK_H
#define COMANIP_TASK_H

#include <stdint.h>

#include "../maths/pose.h"
#include "../protocol/messages.h"
#include "comanip_tasks.h"

typedef struct {
    task_form_t form;
    vector3_t t_task_m;  /* in the robot hand's frame */
    quaternion_t q_task; /* unit */
    quaternion_t q_inv;  /* unit: how the person stands at the start; used by Algorithm 1's initialisation only */
} task_t;

/* The built-in tasks of Table I, by task_id_t; at TASK_CUSTOM, and at numbers that no task has, zeros. */
extern const task_t task_table[COMANIP_TASK_NUMBERS];

/* NULL: no built-in task has this number. */
const task_t *task_built_in(uint8_t number);

/* q_task as a function of how far the human's hand has moved along the torso's x axis since the start: that
 * displacement times `slope` adds to the translation along z. */
typedef struct {
    pose_t pose;
    float slope; /* 0: constant */
} task_relation_t;

task_relation_t task_relation(const task_t *task);

/* Equation (2): q_task at this displacement. */
pose_t task_relation_at(const task_relation_t *relation, float forward_displacement_m);

/* From a (s = 0) to b (s = 1), as pose_interpolate(). */
task_relation_t task_relation_interpolate(const task_relation_t *a, const task_relation_t *b, float s);

#endif
