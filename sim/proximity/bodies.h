/* The people and the robot as convex shapes at their current poses. The sizes of a person's hand and forearm and of the
 * robot's torso, head and gripper are assumed; the sizes of the robot's arm are from robot_model.h. */
#ifndef COMANIP_SIM_BODIES_H
#define COMANIP_SIM_BODIES_H

#include <stdbool.h>

#include "../scene/scene.h"
#include "convex_shape.h"

#define BODIES_PERSON_PARTS 4 /* person_part_t */
#define BODIES_ROBOT_PARTS 8  /* robot_part_t */
#define BODIES_FOREARM_POINTS 16
#define BODIES_WRIST_M 0.060 /* from a person's wrist forward to the centre of the palm, the hand's origin */
#define BODY_NO_OBJECT (-1)

typedef struct {
    convex_shape_t shape;
    bool present;
    int object;         /* index of the rod, or BODY_NO_OBJECT */
    double travelled_m; /* upper bound of any point's path length; increased by a jump when another rod is held */
} body_t;

typedef struct {
    body_t robot[BODIES_ROBOT_PARTS];
    body_t person[SCENARIO_MAX_PEOPLE][BODIES_PERSON_PARTS];
    double forearm_m[SCENARIO_MAX_PEOPLE]; /* length of each forearm */
    double forearm_point[SCENARIO_MAX_PEOPLE][BODIES_FOREARM_POINTS][3];
} bodies_t;

/* self must not be copied or moved, because its shapes point into it. */
void bodies_init(bodies_t *self, const scenario_t *scenario);

/* Sets the poses from the current scene. */
void bodies_place(bodies_t *self, const scenario_t *scenario, const scene_t *scene);

/* Helpers shared by bodies.c and body_shapes.c. */
void body_set_rod(body_t *self, const object_t *rod);
rigid_pose_t body_wrist(const rigid_pose_t *hand);
double body_distance_m(const double a[3], const double b[3]);

#endif
