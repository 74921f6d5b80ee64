/* What the people and the robot handle, as rigid bodies: rods, cranks, and the stands that rods lie on. */
#ifndef COMANIP_SIM_OBJECTS_H
#define COMANIP_SIM_OBJECTS_H

#include "../common/rigid_pose.h"
#include "../scenario/scenario.h"

#define OBJECTS_GROUND_Z_M (-0.4) /* torso axes */

struct dxBody;
struct dxJoint;
struct dxWorld;

typedef struct {
    const object_t *data;
    struct dxBody *body;    /* NULL: a stand */
    struct dxJoint *hinge;  /* of a crank */
    double hinge_angle_rad; /* unwrapped, from the start */
    double last_angle_rad;  /* as ODE gives it, -pi..pi */
} scene_object_t;

void scene_object_init(scene_object_t *self, struct dxWorld *world, const object_t *data);

/* Before a step: what damps a rod's spin, and a crank's turn in the step before. */
void scene_object_prepare(scene_object_t *self);

/* A rod's middle; a crank's hinge, turned; a stand as it stands. */
void scene_object_pose(const scene_object_t *self, rigid_pose_t *pose);

/* A point along_m from the middle of the axis at which the object is held: a rod's own, a crank's handle. */
void scene_object_point(const scene_object_t *self, double along_m, double position_m[3]);

/* The axis' point that is nearest to `position_m`, and how far it is. */
double scene_object_nearest(const scene_object_t *self, const double position_m[3], double nearest_m[3]);

#endif
