/* Bringing a point to another by sight: one move, then short ones until it is near enough. A reaching person brings the
 * own grip; a guiding one brings a point that the robot carries, and knows how the robot follows the own hand. */
#ifndef COMANIP_SIM_APPROACH_H
#define COMANIP_SIM_APPROACH_H

#include <stddef.h>

#include "../hand/hand_path.h"
#include "../scene/scene.h"

typedef struct {
    const person_step_t *step; /* PERSON_REACH or PERSON_GUIDE */
    size_t person;
    const scene_t *scene;
    hand_path_t path;
    int corrections;
} approach_t;

typedef enum { APPROACH_MOVES, APPROACH_THERE, APPROACH_FAILED } approach_status_t;

/* The first move, from the aimed hand at begin_s on. robot_follows: of the person's program. */
void approach_begin(approach_t *self, const rigid_pose_t *aim, const double robot_follows[3], double begin_s);

/* Looks at the scene of now_s, and begins a correction where one is needed. miss_m: how far off it is. */
approach_status_t approach_look(approach_t *self, const double robot_follows[3], double now_s, double *miss_m);

#endif
