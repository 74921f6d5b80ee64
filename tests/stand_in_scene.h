/* A scene without physics for the tests of people's programs: a hand is at its aim plus a sag; the robot's gripper
 * follows the first person's hand. stand_in_scene.c has the functions of scene.h that a program uses. */
#ifndef COMANIP_TESTS_STAND_IN_SCENE_H
#define COMANIP_TESTS_STAND_IN_SCENE_H

#include "../sim/scene/scene.h"

typedef struct {
    rigid_pose_t hand[SCENARIO_MAX_PEOPLE];
    double sag_m[SCENARIO_MAX_PEOPLE][3]; /* actual position minus the aim */
    double gripper_start_m[3];
    double gripper_follows[3]; /* share of the first hand's displacement, per axis */
    rigid_pose_t object[SCENARIO_MAX_OBJECTS];
    double crank_turns;
    bool can_grip;
    bool holds[SCENARIO_MAX_OBJECTS]; /* in the first person's hand */
    int closings, openings;           /* counted calls */
} fake_state_t;

fake_state_t *stand_in_scene_state(scene_t *self);

#endif
