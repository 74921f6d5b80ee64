#include "joint_ends.h"

uint8_t joint_ends_beyond(const velocity_request_t *request, int joint_count, const float velocity_radps[]) {
    unsigned beyond = 0;
    for (int i = 0; i < joint_count; i++) {
        const bool is_upper = (request->at_upper_end >> i & 1) != 0;
        if (is_upper ? velocity_radps[i] > 0.0f : velocity_radps[i] < 0.0f) {
            beyond |= 1u << i;
        }
    }
    return (uint8_t)(beyond & request->at_end);
}

void joint_ends_solve(const velocity_request_t *request, int joint_count, ldlt_t *normal, float velocity_radps[]) {
    float pull[ARM_MAX_JOINTS];
    for (int i = 0; i < joint_count; i++) {
        pull[i] = velocity_radps[i];
    }
    for (;;) { /* 1 + joint_count times at most: who is out stands, and is not beyond again */
        ldlt_factorise(normal, joint_count);
        ldlt_solve(normal, joint_count, velocity_radps);
        const uint8_t beyond = joint_ends_beyond(request, joint_count, velocity_radps);
        if (beyond == 0u) {
            return;
        }
        ldlt_leave_out(normal, joint_count, beyond);
        for (int i = 0; i < joint_count; i++) {
            pull[i] = (beyond >> i & 1) != 0 ? 0.0f : pull[i];
            velocity_radps[i] = pull[i];
        }
    }
}
