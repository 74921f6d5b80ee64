#include "arm.h"

#include <stdbool.h>
#include <stddef.h>

#include "trigonometry.h"

#define UNIT_TOLERANCE 1e-4f

static bool is_pose(dual_quaternion_t pose) {
    float product = quaternion_dot(pose.primary, pose.dual);
    return quaternion_is_unit(pose.primary, UNIT_TOLERANCE) && product > -UNIT_TOLERANCE && product < UNIT_TOLERANCE;
}

const char *arm_check(const arm_t *arm) {
    if (arm->joint_count < 1 || arm->joint_count > ARM_MAX_JOINTS) {
        return "arm table: joint_count must be 1 to 8";
    }
    if (!is_pose(arm->effector)) {
        return "arm table: effector is not a unit dual quaternion";
    }
    for (int i = 0; i < arm->joint_count; i++) {
        const arm_joint_t *joint = &arm->joints[i];
        if (!is_pose(joint->fixed)) {
            return "arm table: a joint's fixed transform is not a unit dual quaternion";
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
    }
    return NULL;
}

static dual_quaternion_t turned(vector3_t axis, float angle_rad, dual_quaternion_t pose) {
    float sine, cosine;
    sine_cosine(0.5f * angle_rad, &sine, &cosine);
    quaternion_t turn = {cosine, sine * axis.x, sine * axis.y, sine * axis.z};
    return (dual_quaternion_t){quaternion_multiply(turn, pose.primary), quaternion_multiply(turn, pose.dual)};
}

/* The joint's axis, a line through the origin, seen from the hand, whose pose is seen from the joint: conj(x) l x, halved. */
static dual_quaternion_t half_line_from_hand(dual_quaternion_t hand, vector3_t axis) {
    const quaternion_t half_axis = {0.0f, 0.5f * axis.x, 0.5f * axis.y, 0.5f * axis.z};
    dual_quaternion_t turned_axis = {quaternion_multiply(half_axis, hand.primary),
                                     quaternion_multiply(half_axis, hand.dual)};
    dual_quaternion_t line = dual_quaternion_multiply(dual_quaternion_conjugate(hand), turned_axis);
    line.primary.w = 0.0f; /* but for rounding, it is pure */
    line.dual.w = 0.0f;
    return line;
}

/* From the hand towards the torso, so that the axes come out as seen from the hand: small numbers, near the hand. */
dual_quaternion_t arm_hand_and_axes(const arm_t *arm, const float position_rad[],
                                    dual_quaternion_t half_line[ARM_MAX_JOINTS]) {
    dual_quaternion_t hand = arm->effector; /* seen from the frame reached so far */
    for (int i = arm->joint_count - 1; i >= 0; i--) {
        const arm_joint_t *joint = &arm->joints[i];
        half_line[i] = half_line_from_hand(hand, joint->axis);
        hand = dual_quaternion_multiply(joint->fixed, turned(joint->axis, position_rad[i], hand));
    }
    return hand;
}

dual_quaternion_t arm_forward_kinematics(const arm_t *arm, const float position_rad[]) {
    dual_quaternion_t hand = arm->effector;
    for (int i = arm->joint_count - 1; i >= 0; i--) {
        const arm_joint_t *joint = &arm->joints[i];
        hand = dual_quaternion_multiply(joint->fixed, turned(joint->axis, position_rad[i], hand));
    }
    return hand;
}

dual_quaternion_t arm_pose_jacobian(const arm_t *arm, const float position_rad[],
                                    dual_quaternion_t column[ARM_MAX_JOINTS]) {
    dual_quaternion_t hand = arm_hand_and_axes(arm, position_rad, column);
    for (int i = 0; i < arm->joint_count; i++) {
        column[i] = dual_quaternion_multiply(hand, column[i]);
    }
    return hand;
}
