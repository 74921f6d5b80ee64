/* A scene without physics for tests of the proximity and gripper nodes. Its state is what the test sets. */
#ifndef COMANIP_TESTS_FAKE_SCENE_H
#define COMANIP_TESTS_FAKE_SCENE_H

#include "../sim/scene/scene.h"

struct arm_plant {
    double position_rad[ROBOT_JOINTS];
};

struct scene {
    arm_plant_t *arm;
    rigid_pose_t hand[SCENARIO_MAX_PEOPLE];
    rigid_pose_t object[SCENARIO_MAX_OBJECTS];
    rigid_pose_t robot_cup;
    bool holds[SCENARIO_MAX_PEOPLE + 1][SCENARIO_MAX_OBJECTS];
    double opening, force_N;
    int commands; /* number of commands sent to the gripper so far */
    bool close;   /* whether the last command closes the gripper */
};

#endif
