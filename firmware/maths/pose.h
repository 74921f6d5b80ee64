/* A pose as rotation and translation: what the tick computes with. The same pose as the dual quaternion r + eps 1/2 t r
 * of dual_quaternion.h; (r, t) and (-r, t) are the same one. */
#ifndef COMANIP_POSE_H
#define COMANIP_POSE_H

#include "dual_quaternion.h"

typedef struct {
    quaternion_t rotation; /* unit */
    vector3_t translation_m;
} pose_t;

/* How a pose moves, in the axes of where it is seen from: d/dt r = 1/2 angular_velocity r. */
typedef struct {
    vector3_t velocity_mps;
    vector3_t angular_velocity_radps;
} twist_t;

extern const pose_t pose_identity;

pose_t pose_from_dual_quaternion(dual_quaternion_t pose);
dual_quaternion_t pose_to_dual_quaternion(pose_t pose);

/* b seen from where a is seen from: the dual quaternions' product a b. */
pose_t pose_multiply(pose_t a, pose_t b);

/* From a (s = 0) to b (s = 1): translation in a straight line, rotation by quaternion_interpolate. */
pose_t pose_interpolate(pose_t a, pose_t b, float s);

#endif
