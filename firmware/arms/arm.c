/* Checks an arm's table and computes the kinematics of any arm: see arm.h. */
#include "arm.h"

#include <stdbool.h>
#include <stddef.h>

#include "../maths/trigonometry.h"

#define UNIT_TOLERANCE 1e-4f
#define REACH_MAX_M 100.0f

static bool is_pose(pose_t pose) {
    const float reach = vector3_dot(pose.translation_m, pose.translation_m);
    return quaternion_is_unit(pose.rotation, UNIT_TOLERANCE) && reach <= REACH_MAX_M * REACH_MAX_M;
}

const char *arm_check(const arm_t *arm) {
    if (arm->joint_count < 1 || arm->joint_count > ARM_MAX_JOINTS) {
        return "arm table: joint_count must be 1 to 8";
    }
    if (arm->forward_kinematics == NULL) {
        return "arm table: forward_kinematics must be set, for example to arm_forward_kinematics";
    }
    if (!(arm->drive_lag_max_s >= 1e-3f && arm->drive_lag_max_s <= 0.1f)) {
        return "arm table: drive_lag_max_s must be from 0.001 to 0.1 s";
    }
    if (!is_pose(arm->effector)) {
        return "arm table: effector is not a pose";
    }
    for (int i = 0; i < arm->joint_count; i++) {
        const arm_joint_t *joint = &arm->joints[i];
        if (!is_pose(joint->fixed)) {
            return "arm table: a joint's fixed transform is not a pose";
        }
        quaternion_t axis = {0.0f, joint->axis.x, joint->axis.y, joint->axis.z};
        if (!quaternion_is_unit(axis, UNIT_TOLERANCE)) {
            return "arm table: a joint's axis is not a unit vector";
        }
        if (!(joint->position_min_rad >= -8.0f && joint->position_max_rad <= 8.0f &&
              joint->position_min_rad < joint->position_max_rad)) {
            return "arm table: a joint's position limits must be ordered and within +-8 rad";
        }
        if (!(joint->velocity_max_radps > 0.0f && joint->velocity_max_radps <= 32.0f)) {
            return "arm table: a joint's velocity limit must be above 0 and at most 32 rad/s";
        }
        if (!(joint->jerk_max_radps3 >= 1e3f && joint->jerk_max_radps3 <= 1e6f)) {
            return "arm table: a joint's jerk limit must be from 1000 to 1e6 rad/s^3";
        }
    }
    return NULL;
}

/* Rotates a pose, given in the joint's frame, about the joint's axis. */
static pose_t turned(vector3_t axis, float angle_rad, pose_t pose) {
    const sine_cosine_t half = sine_cosine(0.5f * angle_rad);
    const quaternion_t turn = {half.cosine, half.sine * axis.x, half.sine * axis.y, half.sine * axis.z};
    return (pose_t){quaternion_multiply(turn, pose.rotation), quaternion_rotate(turn, pose.translation_m)};
}

pose_t arm_forward_kinematics(const arm_t *arm, const float position_rad[]) {
    pose_t end_effector = arm->effector;
    for (int i = arm->joint_count - 1; i >= 0; i--) {
        const arm_joint_t *joint = &arm->joints[i];
        end_effector = pose_multiply(joint->fixed, turned(joint->axis, position_rad[i], end_effector));
    }
    return end_effector;
}

/* Proceeds from the end effector towards the torso. The columns are in the end effector's frame, in which levers are
 * short and rounding errors small. */
void arm_jacobian(const arm_t *arm, const float position_rad[], arm_jacobian_t *jacobian) {
    pose_t end_effector = arm->effector; /* in the current joint's frame, whose origin is on the joint's axis */
    for (int i = arm->joint_count - 1; i >= 0; i--) {
        const arm_joint_t *joint = &arm->joints[i];
        const quaternion_t to_end_effector = quaternion_conjugate(end_effector.rotation);
        jacobian->angular[i] = quaternion_rotate(to_end_effector, joint->axis);
        jacobian->linear_m[i] =
            quaternion_rotate(to_end_effector, vector3_cross(joint->axis, end_effector.translation_m));
        end_effector = pose_multiply(joint->fixed, turned(joint->axis, position_rad[i], end_effector));
    }
    jacobian->end_effector = end_effector;
}

dual_quaternion_t arm_half_twist(vector3_t angular, vector3_t linear_m) {
    return (dual_quaternion_t){
        {0.0f, 0.5f * angular.x, 0.5f * angular.y, 0.5f * angular.z},
        {0.0f, 0.5f * linear_m.x, 0.5f * linear_m.y, 0.5f * linear_m.z},
    };
}
