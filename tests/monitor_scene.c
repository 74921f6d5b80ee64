// Replaces the scene, which needs ODE, in the tests of the scenario monitors. Each function returns fixed
// values that depend only on its arguments.

#include "../sim/scene/scene.h"

void scene_hand(const scene_t *s, size_t person, rigid_pose_t *hand) {
    (void)s;
    *hand = (rigid_pose_t){{10.0 + (double)person, 0.25, -0.5}, {1.0, 0.0, 0.0, 0.0}};
}
void scene_hand_force_N(const scene_t *s, size_t person, double force_N[3]) {
    (void)s;
    for (int k = 0; k < 3; k++) {
        force_N[k] = (double)(k + 1) * (1.0 + (double)person);
    }
}
void scene_object(const scene_t *s, size_t object, rigid_pose_t *pose) {
    (void)s;
    *pose = (rigid_pose_t){{20.0 + (double)object, 0.0, 0.0}, {0.0, 1.0, 0.0, 0.0}};
}
double scene_crank_turns(const scene_t *s, size_t object) {
    (void)s;
    return 0.5 + (double)object;
}
bool scene_holds(const scene_t *s, size_t holder, size_t object) {
    (void)s;
    return holder == object % 3;
}
double scene_gripper_opening(const scene_t *s) {
    (void)s;
    return 0.75;
}
double scene_gripper_force_N(const scene_t *s) {
    (void)s;
    return 8.5;
}
void scene_robot_cup(const scene_t *s, rigid_pose_t *cup) {
    (void)s;
    *cup = (rigid_pose_t){{1.0, 2.0, 3.0}, {1.0, 0.0, 0.0, 0.0}};
}
water_count_t scene_water(const scene_t *s) {
    (void)s;
    return (water_count_t){50, 6, 4, 11};
}
