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

/* One step down the chain: the frame in which the joint's axis is fixed becomes the joint's moving frame. */
static dual_quaternion_t turn_joint(dual_quaternion_t frame, vector3_t axis, float angle_rad) {
    float sine, cosine;
    sine_cosine(0.5f * angle_rad, &sine, &cosine);
    quaternion_t turn = {cosine, sine * axis.x, sine * axis.y, sine * axis.z};
    return (dual_quaternion_t){quaternion_multiply(frame.primary, turn), quaternion_multiply(frame.dual, turn)};
}

/* The joint's axis as a line in the torso frame, halved: 1/2 (l + eps p x l). */
static dual_quaternion_t half_line(dual_quaternion_t frame, vector3_t axis) {
    vector3_t l = quaternion_rotate(frame.primary, axis);
    vector3_t p = dual_quaternion_translation(frame);
    return (dual_quaternion_t){
        {0.0f, 0.5f * l.x, 0.5f * l.y, 0.5f * l.z},
        {0.0f, 0.5f * (p.y * l.z - p.z * l.y), 0.5f * (p.z * l.x - p.x * l.z), 0.5f * (p.x * l.y - p.y * l.x)},
    };
}

dual_quaternion_t arm_forward_kinematics(const arm_t *arm, const float position_rad[]) {
    dual_quaternion_t frame = dual_quaternion_identity;
    for (int i = 0; i < arm->joint_count; i++) {
        const arm_joint_t *joint = &arm->joints[i];
        frame = turn_joint(dual_quaternion_multiply(frame, joint->fixed), joint->axis, position_rad[i]);
    }
    return dual_quaternion_multiply(frame, arm->effector);
}

dual_quaternion_t arm_pose_jacobian(const arm_t *arm, const float position_rad[],
                                    dual_quaternion_t column[ARM_MAX_JOINTS]) {
    dual_quaternion_t frame = dual_quaternion_identity;
    for (int i = 0; i < arm->joint_count; i++) {
        const arm_joint_t *joint = &arm->joints[i];
        frame = dual_quaternion_multiply(frame, joint->fixed);
        column[i] = half_line(frame, joint->axis);
        frame = turn_joint(frame, joint->axis, position_rad[i]);
    }
    dual_quaternion_t hand = dual_quaternion_multiply(frame, arm->effector);
    for (int i = 0; i < arm->joint_count; i++) {
        column[i] = dual_quaternion_multiply(column[i], hand);
    }
    return hand;
}
