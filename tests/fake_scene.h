/* A scene with a state that the test sets, for the modules that read scenes (proximity and gripper node). */
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
