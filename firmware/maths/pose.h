/* A pose as a rotation and a translation, the form used for computation in a tick. It is the same pose as the dual
 * quaternion r + eps 1/2 t r of dual_quaternion.h; (r, t) and (-r, t) are the same pose. */
#ifndef COMANIP_POSE_H
#define COMANIP_POSE_H

#include "dual_quaternion.h"

typedef struct {
    quaternion_t rotation; /* unit */
    vector3_t translation_m;
} pose_t;

/* The velocity of a pose, in the axes of its reference frame: d/dt r = 1/2 angular_velocity r. */
typedef struct {
    vector3_t velocity_mps;
    vector3_t angular_velocity_radps;
} twist_t;

extern const pose_t pose_identity;

pose_t pose_from_dual_quaternion(dual_quaternion_t pose);
dual_quaternion_t pose_to_dual_quaternion(pose_t pose);

/* Returns the product a b of the two dual quaternions: if b is given in the frame a, the result is b in the frame in
 * which a is given. */
pose_t pose_multiply(pose_t a, pose_t b);

/* Interpolates from a (s = 0) to b (s = 1), with the translation along a straight line and the rotation as in
 * quaternion_interpolate(). */
pose_t pose_interpolate(pose_t a, pose_t b, float s);

#endif
