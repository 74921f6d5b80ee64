/* Joints at their position limits: see joints_at_limit.h. */
#include "joints_at_limit.h"

#include "../maths/float_bits.h"

joints_at_limit_t joints_at_limit_find(const arm_t *arm, const float margin_rad[], const float position_rad[]) {
    unsigned lower = 0, upper = 0;
    for (int i = 0; i < arm->joint_count; i++) {
        const arm_joint_t *joint = &arm->joints[i];
        const unsigned bit = 1u << i;
        lower |= float_is_below(position_rad[i] - joint->position_min_rad, margin_rad[i]) ? bit : 0u;
        upper |= float_is_below(joint->position_max_rad - position_rad[i], margin_rad[i]) ? bit : 0u;
    }
    return (joints_at_limit_t){(uint8_t)lower, (uint8_t)upper};
}

uint8_t joints_at_limit_going_beyond(joints_at_limit_t self, int joint_count, const float velocity_radps[]) {
    unsigned beyond = 0;
    for (int i = 0; i < joint_count; i++) {
        const unsigned bit = 1u << i;
        if (((self.lower & bit) != 0u && velocity_radps[i] < 0.0f) ||
            ((self.upper & bit) != 0u && velocity_radps[i] > 0.0f)) {
            beyond |= bit;
        }
    }
    return (uint8_t)beyond;
}
