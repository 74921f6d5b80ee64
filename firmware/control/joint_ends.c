#include "joint_ends.h"

uint8_t joint_ends_leave_out(joint_ends_t ends, int joint_count, const float velocity_radps[], uint8_t *out) {
    unsigned beyond = 0;
    for (int i = 0; i < joint_count; i++) {
        const unsigned bit = 1u << i;
        if (((ends.lower & bit) != 0u && velocity_radps[i] < 0.0f) ||
            ((ends.upper & bit) != 0u && velocity_radps[i] > 0.0f)) {
            beyond |= bit;
        }
    }
    const uint8_t more = (uint8_t)(beyond & ~(unsigned)*out);
    *out = (uint8_t)(*out | more);
    return more;
}

void joint_ends_solve(joint_ends_t ends, int joint_count, ldlt_t *normal, float velocity_radps[]) {
    float pull[ARM_MAX_JOINTS];
    for (int i = 0; i < joint_count; i++) {
        pull[i] = velocity_radps[i];
    }
    uint8_t out = 0;
    for (;;) {
        ldlt_factorise(normal, joint_count);
        ldlt_solve(normal, joint_count, velocity_radps);
        const uint8_t more = joint_ends_leave_out(ends, joint_count, velocity_radps, &out);
        if (more == 0u) {
            return;
        }
        ldlt_leave_out(normal, joint_count, more);
        for (int i = 0; i < joint_count; i++) {
            pull[i] = (more >> i & 1) != 0 ? 0.0f : pull[i];
            velocity_radps[i] = pull[i];
        }
    }
}
