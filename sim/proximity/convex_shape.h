/* Convex shapes and the distance between two of them, through libccd: GJK decides whether two shapes meet when one of
 * them is inflated by a margin, and the margin at which they just meet, found by bisection, is the distance. */
#ifndef COMANIP_SIM_CONVEX_SHAPE_H
#define COMANIP_SIM_CONVEX_SHAPE_H

#include "../common/rigid_pose.h"

typedef enum {
    SHAPE_BOX,      /* size_m */
    SHAPE_CAPSULE,  /* along z: length_m between the centres of its ends, radius_m */
    SHAPE_CYLINDER, /* along z: length_m, radius_m */
    SHAPE_HULL,     /* of `points` */
} convex_kind_t;

typedef struct {
    convex_kind_t kind;
    double size_m[3];
    double length_m, radius_m;
    const double (*points)[3]; /* in the shape's frame; SHAPE_HULL */
    int point_count;
    double bounding_radius_m; /* of a sphere about the frame's origin: filled by convex_shape_finish() */
    rigid_pose_t pose;        /* of its frame, torso axes */
} convex_shape_t;

#define CONVEX_DISTANCE_ERROR_M                                                                                        \
    0.00005 /* bound of convex_distance_m()'s error, for shapes up to 1 m across and apart */
#define CONVEX_OVERLAP_ERROR_M 0.0003

void convex_shape_finish(convex_shape_t *self);

/* Least distance, at least 0 (they touch or overlap); at most `ceiling_m`: what lies beyond is not searched. guess_m:
 * of an earlier instant, or negative; makes it faster, not different beyond the error bound. */
double convex_distance_m(const convex_shape_t *a, const convex_shape_t *b, double ceiling_m, double guess_m);

/* The shortest way that separates them, 0: they do not overlap. Never too little; mostly exact to 10 um, too much by
 * CONVEX_OVERLAP_ERROR_M at most (found with random boxes and hulls, not proven). */
double convex_overlap_m(const convex_shape_t *a, const convex_shape_t *b);

#endif
