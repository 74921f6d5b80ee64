/* Implements the functions of scene.h and arm_plant.h that the proximity and gripper nodes call. They return the state
 * that the test has set. */
#include "fake_scene.h"

double arm_plant_position_rad(const arm_plant_t *self, int joint) {
    return self->position_rad[joint];
}

arm_plant_t *scene_arm(const scene_t *self) {
    return self->arm;
}

void scene_command_gripper(scene_t *self, bool close) {
    self->commands++;
    self->close = close;
}

double scene_gripper_opening(const scene_t *self) {
    return self->opening;
}

bool scene_robot_holds(const scene_t *self) {
    bool holds = false;
    for (int i = 0; i < SCENARIO_MAX_OBJECTS; i++) {
        holds = holds || self->holds[SCENE_HOLDER_ROBOT][i];
    }
    return holds;
}

double scene_gripper_force_N(const scene_t *self) {
    return self->force_N;
}

void scene_robot_cup(const scene_t *self, rigid_pose_t *cup) {
    *cup = self->robot_cup;
}

void scene_hand(const scene_t *self, size_t person, rigid_pose_t *hand) {
    *hand = self->hand[person];
}

void scene_object(const scene_t *self, size_t object, rigid_pose_t *pose) {
    *pose = self->object[object];
}

bool scene_holds(const scene_t *self, size_t holder, size_t object) {
    return self->holds[holder][object];
}
