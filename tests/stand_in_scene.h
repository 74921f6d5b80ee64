/* A scene without physics for the tests of people's programs: a hand is where it is aimed, plus a sag; the robot's
 * gripper goes along with the first person's hand. The parts of scene.h that a program uses are in stand_in_scene.c. */
#ifndef COMANIP_TESTS_STAND_IN_SCENE_H
#define COMANIP_TESTS_STAND_IN_SCENE_H

#include "../sim/scene/scene.h"

typedef struct {
    rigid_pose_t hand[SCENARIO_MAX_PEOPLE];
    double sag_m[SCENARIO_MAX_PEOPLE][3]; /* of the actual hand against the aim */
    double gripper_start_m[3];
    double gripper_follows[3]; /* of the first hand's displacement from its start */
    rigid_pose_t object[SCENARIO_MAX_OBJECTS];
    double crank_turns;
    bool can_grip;
    bool holds[SCENARIO_MAX_OBJECTS]; /* in the first person's hand */
    int closings, openings;           /* calls */
} fake_state_t;

fake_state_t *stand_in_scene_state(scene_t *self);

#endif
