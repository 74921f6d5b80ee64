/* A serial arm described by a constant table, and its kinematics in dual quaternions (equation (3)).
 *
 * Frames: torso (x forward, y left, z up) -> joint 0 -> ... -> hand (z forward, x up when the forearm points forward). */
#ifndef COMANIP_ARM_H
#define COMANIP_ARM_H

#include <stdint.h>

#include "dual_quaternion.h"

#define ARM_MAX_JOINTS 8

/* One revolute joint: from the previous joint's moving frame (the torso for the first) by `fixed`, then a rotation of
 * the joint's angle about `axis`. */
typedef struct {
    dual_quaternion_t fixed; /* unit */
    vector3_t axis;          /* unit, in the frame reached by `fixed` */
    float position_min_rad;  /* usable range, already inside the mechanical stops; within +-8 rad */
    float position_max_rad;
    float velocity_max_radps; /* > 0, at most 32 */
} arm_joint_t;

typedef struct {
    const char *name;
    uint8_t id;          /* FirmwareIdentity.arm in the DBC */
    uint8_t joint_count; /* 1..ARM_MAX_JOINTS */
    const arm_joint_t *joints;
    dual_quaternion_t effector; /* from the last joint's moving frame to the hand; unit */
} arm_t;

/* NULL if the table is within the ranges above, else a line that names the defect. */
const char *arm_check(const arm_t *arm);

/* Hand pose seen from the torso. position_rad: joint_count angles, each within TRIGONOMETRY_MAX_RAD. */
dual_quaternion_t arm_forward_kinematics(const arm_t *arm, const float position_rad[]);

/* Forward kinematics, and each joint's axis as a line seen from the hand, halved: 1/2 (l + eps p x l), with l the axis and p
 * a point on it; pure dual quaternions. hand * half_line[i] is column i of the Jacobian, seen from wherever the hand is. */
dual_quaternion_t arm_hand_and_axes(const arm_t *arm, const float position_rad[],
                                    dual_quaternion_t half_line[ARM_MAX_JOINTS]);

/* Forward kinematics and the analytic 8 x n Jacobian: column i is d(vec8 hand)/d(position i). The columns have the sign
 * of the returned hand. */
dual_quaternion_t arm_pose_jacobian(const arm_t *arm, const float position_rad[],
                                    dual_quaternion_t column[ARM_MAX_JOINTS]);

#endif
