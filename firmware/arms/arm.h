/* A serial arm, described by a constant table, and its kinematics.
 *
 * Frames: torso (x forward, y left, z up) -> joint 0 -> ... -> end effector (z forward, x up when the forearm points
 * forward). */
#ifndef COMANIP_ARM_H
#define COMANIP_ARM_H

#include <stdint.h>

#include "../maths/pose.h"

#define ARM_MAX_JOINTS 8

typedef struct arm arm_t;

/* One revolute joint. `fixed` is the transform from the previous joint's moving frame (for the first joint, from the
 * torso) to the joint, which then rotates by its angle about `axis`. */
typedef struct {
    pose_t fixed;           /* translation within 100 m */
    vector3_t axis;         /* unit vector, in the frame that `fixed` leads to */
    float position_min_rad; /* usable range, inside the mechanical stops and within +-8 rad */
    float position_max_rad;
    float velocity_max_radps; /* greater than 0, at most 32 */
    float jerk_max_radps3;    /* 1000 to 1e6; with 1000 and a tick of 1 ms, jerk_steps of joint_limits.h is 1 */
} arm_joint_t;

/* A function with the same contract as arm_forward_kinematics(). */
typedef pose_t arm_kinematics_t(const arm_t *arm, const float position_rad[]);

struct arm {
    const char *name;
    uint8_t id;          /* FirmwareIdentity.arm in the DBC */
    uint8_t joint_count; /* 1..ARM_MAX_JOINTS */
    /* The largest time by which a healthy drive's reported motion lags behind its command on the bus: 0.001 to 0.1. */
    float drive_lag_max_s;
    const arm_joint_t *joints;
    pose_t effector;                      /* the end effector's pose in the last joint's moving frame */
    arm_kinematics_t *forward_kinematics; /* arm_forward_kinematics(), or the function that `make arms` generated */
};

/* The end effector's pose in the torso frame, and the geometric Jacobian in the end effector's frame. Column i is the
 * end effector's twist per rad/s of joint i: `angular` is the joint's axis, and `linear_m` is p x axis, where p is a
 * point on the axis. */
typedef struct {
    pose_t end_effector;
    vector3_t angular[ARM_MAX_JOINTS];
    vector3_t linear_m[ARM_MAX_JOINTS];
} arm_jacobian_t;

/* Returns NULL if the table is complete and its values are within the ranges above; otherwise, returns a one-line
 * message that names the defect. */
const char *arm_check(const arm_t *arm);

/* Returns the end effector's pose in the torso frame (equation (3)), for any arm. Prefer arm->forward_kinematics(),
 * which is faster if it was generated for the arm. position_rad: joint_count angles, each within
 * TRIGONOMETRY_MAX_RAD. */
pose_t arm_forward_kinematics(const arm_t *arm, const float position_rad[]);

void arm_jacobian(const arm_t *arm, const float position_rad[], arm_jacobian_t *jacobian);

/* Returns a column of the geometric Jacobian, multiplied by 1/2, as a dual quaternion h. If x is the end effector's
 * pose as a dual quaternion, the product x h is the joint's column of the analytic 8 x n Jacobian, d(vec8 x) /
 * d(position). Replacing x by -x, which is the same pose, changes the sign of this column. */
dual_quaternion_t arm_half_twist(vector3_t angular, vector3_t linear_m);

#endif
