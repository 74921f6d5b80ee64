/* A pose as rotation and translation, the form in which the tick computes. It is the same pose as the dual quaternion
 * r + eps 1/2 t r of dual_quaternion.h; (r, t) and (-r, t) are the same pose. */
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

/* The product a b of the dual quaternions: b, given in the frame a, in the reference frame of a. */
pose_t pose_multiply(pose_t a, pose_t b);

/* From a (s = 0) to b (s = 1): translation in a straight line, rotation by quaternion_interpolate(). */
pose_t pose_interpolate(pose_t a, pose_t b, float s);

#endif
