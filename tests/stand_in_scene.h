/* A scene without physics for the tests of the simulated people's programs. Each hand is at its commanded position plus
 * a constant sag, and the robot's gripper follows the first person's hand. */
#ifndef COMANIP_TESTS_STAND_IN_SCENE_H
#define COMANIP_TESTS_STAND_IN_SCENE_H

#include "../sim/scene/scene.h"

typedef struct {
    rigid_pose_t hand[SCENARIO_MAX_PEOPLE];
    double sag_m[SCENARIO_MAX_PEOPLE][3]; /* actual position minus commanded position */
    double gripper_start_m[3];
    double gripper_follows[3]; /* gripper displacement per unit displacement of the first hand, for each axis */
    rigid_pose_t object[SCENARIO_MAX_OBJECTS];
    double crank_turns;
    bool can_grip;
    bool holds[SCENARIO_MAX_OBJECTS]; /* in the first person's hand */
    int closings, openings;           /* numbers of calls */
} fake_state_t;

fake_state_t *stand_in_scene_state(scene_t *self);

#endif
