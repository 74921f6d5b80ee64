/* Rigid bodies of the objects that people and robot handle: rods, cranks, and the stands that rods lie on. */
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
    struct dxBody *body;    /* NULL for a stand */
    struct dxJoint *hinge;  /* hinge of a crank */
    double hinge_angle_rad; /* unwrapped, 0 at the start */
    double last_angle_rad;  /* as ODE reports it, from -pi to pi */
} scene_object_t;

void scene_object_init(scene_object_t *self, struct dxWorld *world, const object_t *data);

/* Damps the spin of a rod, and adds a crank's rotation in the last step to the crank's angle. Call it before each
 * step. */
void scene_object_prepare(scene_object_t *self);

/* Computes the pose of the centre of a rod or a stand, or of a crank's hinge, turned by the crank's current angle. */
void scene_object_pose(const scene_object_t *self, rigid_pose_t *pose);

/* Computes the position of the point at offset along_m from the centre of the axis by which the object is held. This
 * is the axis of a rod or of a crank's handle. */
void scene_object_point(const scene_object_t *self, double along_m, double position_m[3]);

/* Finds the point nearest to `position_m` on the axis by which the object is held. Returns the distance
 * between the two points. */
double scene_object_nearest(const scene_object_t *self, const double position_m[3], double nearest_m[3]);

#endif
