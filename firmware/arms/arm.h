/* A serial arm described by a constant table, and its kinematics.
 *
 * Frames: torso (x forward, y left, z up) -> joint 0 -> ... -> hand (z forward, x up when the forearm points forward).
 */
#ifndef COMANIP_ARM_H
#define COMANIP_ARM_H

#include <stdint.h>

#include "../maths/pose.h"

#define ARM_MAX_JOINTS 8

typedef struct arm arm_t;

/* One revolute joint: from the previous joint's moving frame (the torso for the first) by `fixed`, then a rotation of
 * the joint's angle about `axis`. */
typedef struct {
    pose_t fixed;           /* translation within 100 m */
    vector3_t axis;         /* unit, in the frame reached by `fixed` */
    float position_min_rad; /* usable range, already inside the mechanical stops; within +-8 rad */
    float position_max_rad;
    float velocity_max_radps; /* > 0, at most 32 */
    float jerk_max_radps3;    /* 1,000 (a step of the bus's resolution in a tick of 1 ms) to 1e6 */
} arm_joint_t;

/* The end effector's pose, as arm_forward_kinematics(). */
typedef pose_t arm_kinematics_t(const arm_t *arm, const float position_rad[]);

struct arm {
    const char *name;
    uint8_t id;          /* FirmwareIdentity.arm in the DBC */
    uint8_t joint_count; /* 1..ARM_MAX_JOINTS */
    const arm_joint_t *joints;
    pose_t effector;                      /* from the last joint's moving frame to the hand */
    arm_kinematics_t *forward_kinematics; /* arm_forward_kinematics(), or what `make arms` wrote for just this arm */
};

/* The end effector's pose seen from the torso, and the geometric Jacobian in the end effector's frame: column i is the
 * twist of the end effector per rad/s of joint i, angular = its axis, linear_m = p x axis with p a point on the axis.
 */
typedef struct {
    pose_t end_effector;
    vector3_t angular[ARM_MAX_JOINTS];
    vector3_t linear_m[ARM_MAX_JOINTS];
} arm_jacobian_t;

/* NULL if the table is complete and within the ranges above, else a line that names the defect. */
const char *arm_check(const arm_t *arm);

/* Hand pose seen from the torso (equation (3)), of any arm; arm->forward_kinematics() is faster where it can be.
 * position_rad: joint_count angles, each within TRIGONOMETRY_MAX_RAD. */
pose_t arm_forward_kinematics(const arm_t *arm, const float position_rad[]);

void arm_jacobian(const arm_t *arm, const float position_rad[], arm_jacobian_t *jacobian);

/* Half a column of the geometric Jacobian as a dual quaternion: the end effector's dual quaternion times it is the
 * joint's column of the analytic 8 x n Jacobian, d(vec8 end effector) / d(position), with that dual quaternion's sign.
 */
dual_quaternion_t arm_half_twist(vector3_t angular, vector3_t linear_m);

#endif
