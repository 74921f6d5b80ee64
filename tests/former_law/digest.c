/* Prints digests of the targets and joint velocities that the control laws without prediction compute for a generated
 * input. The samples of a hand that moves and turns at random are interpolated and mapped by Algorithm 1, and control
 * law (4) is applied at random joint positions, some of them at a limit. This file also compiles with the firmware as
 * it was before prediction was added. tests/test_former_law.py compares the output with before_prediction.txt, the
 * output of that firmware. */
#include <stdio.h>
#include <string.h>

#include "../../firmware/control/arms/hoap3_right_ik.h"
#include "../../firmware/control/cooperation.h"
#include "../../firmware/control/hand_tracker.h"
#include "../../firmware/parameters/parameters.h"

#define TICKS 20000
#define TRACKER_TICKS 4u

static uint32_t state = 1;

/* Returns a pseudo-random number in -1..1. */
static float random_number(void) {
    state = state * 1664525u + 1013904223u;
    return (float)(int32_t)state * (1.0f / 2147483648.0f);
}

static uint64_t digest = 14695981039346656037u; /* FNV-1a */

static void take(const void *bytes, size_t count) {
    const unsigned char *byte = bytes;
    for (size_t i = 0; i < count; i++) {
        digest = (digest ^ byte[i]) * 1099511628211u;
    }
}

static void set_gains(parameters_t *parameters, const float gain[8], const float weight[8], float damping,
                      float error_frame) {
    for (int i = 0; i < 8; i++) {
        parameters->value[PARAMETER_GAIN_PER_S + i] = gain[i];
        parameters->value[PARAMETER_WEIGHT + i] = weight[i];
    }
    parameters->value[PARAMETER_DAMPING] = damping;
    parameters->value[PARAMETER_ERROR_FRAME] = error_frame;
}

static void run(const char *name, const parameters_t *parameters, task_id_t task) {
    const arm_ik_t *ik = &arm_ik_hoap3_right;
    const arm_t *arm = ik->arm;
    differential_ik_config_t law;
    cooperation_config_t mapping;
    parameters_differential_ik(parameters, &law);
    parameters_cooperation(parameters, &mapping);
    cooperation_t cooperation;
    hand_tracker_t tracker;
    hand_tracker_init(&tracker, 4000u);
    float joint[ARM_MAX_JOINTS] = {0.8f, -0.6f, 0.1f, -1.2f};
    hand_pose_t sample = {.rotation = {1.0f, 0.0f, 0.0f, 0.0f}, .valid = true};
    for (uint32_t tick = 1; tick <= TICKS; tick++) {
        const uint32_t now_us = 1000u * tick;
        if (tick % TRACKER_TICKS == 1u) {
            quaternion_t turned = sample.rotation;
            turned.x += 0.02f * random_number();
            turned.y += 0.02f * random_number();
            turned.z += 0.02f * random_number();
            sample.rotation = quaternion_normalise(turned);
            sample.position_m.x = 0.99f * sample.position_m.x + 0.01f * random_number();
            sample.position_m.y = 0.99f * sample.position_m.y + 0.01f * random_number();
            sample.position_m.z = 0.99f * sample.position_m.z + 0.01f * random_number();
            sample.t_us = now_us;
            (void)hand_tracker_receive(&tracker, &sample, now_us, now_us);
        }
        for (int i = 0; i < arm->joint_count; i++) {
            const float middle = 0.5f * (arm->joints[i].position_min_rad + arm->joints[i].position_max_rad);
            joint[i] += 0.01f * random_number() + 0.001f * (middle - joint[i]);
        }
        const pose_t hand = hand_tracker_pose(&tracker, now_us);
        if (tick == 1u) {
            cooperation_start(&cooperation, &mapping, &task_table[task], hand, arm->forward_kinematics(arm, joint));
        }
        cooperation_update(&cooperation, &hand, tick < 1000u ? 0.001f * (float)tick : 1.0f);
        const uint8_t lower = tick % 7u == 0u ? (uint8_t)(tick & 15u) : 0u;
        const differential_ik_request_t request = {
            .position_rad = joint,
            .target = &cooperation.target,
            .at_limit = {lower, tick % 11u == 0u ? (uint8_t)(15u & ~lower) : 0u}};
        float velocity_radps[ARM_MAX_JOINTS] = {0.0f};
        arm_ik_differential(ik, &law, &request, velocity_radps);
        take(&cooperation.target, sizeof cooperation.target);
        take(velocity_radps, sizeof velocity_radps);
    }
    (void)printf("%s %016llx\n", name, (unsigned long long)digest);
}

int main(void) {
    static const float ones[8] = {1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f};
    static const float default_gain[8] = {35.0f, 35.0f, 35.0f, 35.0f, 35.0f, 35.0f, 35.0f, 35.0f};
    static const float default_weight[8] = {0.01f, 0.01f, 0.01f, 0.01f, 100.0f, 100.0f, 100.0f, 100.0f};
    static const float paper_gain[8] = {3.0f, 3.0f, 3.0f, 3.0f, 192.0f, 192.0f, 192.0f, 192.0f};
    static const float gain[8] = {1.0f, 2.0f, 3.0f, 4.0f, 50.0f, 60.0f, 70.0f, 80.0f};
    static const float weight[8] = {3.0f, 1.0f, 4.0f, 1.0f, 5.0f, 9.0f, 2.0f, 6.0f};
    parameters_t parameters;
    parameters_set_defaults(&parameters);
    for (task_id_t task = TASK_POUR; task <= TASK_MIRROR; task++) {
        set_gains(&parameters, default_gain, default_weight, 0.01f, 1.0f);
        run("default", &parameters, task);
        set_gains(&parameters, paper_gain, ones, 0.03f, 0.0f);
        run("paper", &parameters, task);
        set_gains(&parameters, gain, weight, 0.001f, 1.0f);
        run("given", &parameters, task);
    }
    return 0;
}
