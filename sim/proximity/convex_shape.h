/* Convex shapes with their poses: boxes, capsules, cylinders and convex hulls. */
#ifndef COMANIP_SIM_CONVEX_SHAPE_H
#define COMANIP_SIM_CONVEX_SHAPE_H

#include "../common/rigid_pose.h"

typedef enum {
    SHAPE_BOX,      /* size_m */
    SHAPE_CAPSULE,  /* along z: length_m between the centres of its ends, radius_m */
    SHAPE_CYLINDER, /* along z: length_m, radius_m */
    SHAPE_HULL,     /* convex hull of `points` */
} convex_kind_t;

typedef struct {
    convex_kind_t kind;
    double size_m[3];
    double length_m, radius_m;
    const double (*points)[3]; /* for SHAPE_HULL, in the shape's frame */
    int point_count;
    double bounding_radius_m; /* of the sphere about the frame's origin that contains the shape */
    rigid_pose_t pose;        /* pose of the shape's frame, in torso axes */
} convex_shape_t;

/* Sets bounding_radius_m from the other members. */
void convex_shape_finish(convex_shape_t *self);

#endif
