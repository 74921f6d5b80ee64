/* Brings a point to its goal as a person does by sight: with one move, and then with short corrections until the
 * distance is small enough. A person who reaches moves their own grip to the goal. A person who guides the robot moves
 * a point that the robot carries, and is assumed to know how far the robot follows the hand (robot_gain). */
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

/* Begins the first move from the hand pose `aim` at begin_s. robot_gain: as in person_program_step(). */
void approach_begin(approach_t *self, const rigid_pose_t *aim, const double robot_gain[3], double begin_s);

/* Once the current move is over, compares the point with its goal, sets miss_m to the remaining distance, and begins a
 * correction if one is needed. */
approach_status_t approach_update(approach_t *self, const double robot_gain[3], double now_s, double *miss_m);

#endif
