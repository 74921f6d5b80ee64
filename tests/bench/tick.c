/* Runs the part of the firmware's tick that the benchmark compares: Algorithm 1, kinematics and control law (4). */
#include "tick.h"

#include <stdlib.h>
#include <string.h>

#include "../../firmware/control/arms/hoap3_right_ik.h"
#include "../../firmware/control/cooperation.h"
#include "seven_ik.h"
#include "six_ik.h"

#define TICK_S 1e-3f

struct tick {
    arm_ik_t ik;
    arm_t arm; /* used if model->name is NULL */
    arm_joint_t joints[ARM_MAX_JOINTS];
    cooperation_t cooperation;
    differential_ik_config_t config;
    float position_rad[ARM_MAX_JOINTS], velocity_radps[ARM_MAX_JOINTS];
    int hand_count;
    pose_t hand[];
};

static pose_t pose(const double *p) {
    return (pose_t){{(float)p[0], (float)p[1], (float)p[2], (float)p[3]}, {(float)p[4], (float)p[5], (float)p[6]}};
}

static void choose_arm(tick_t *self, const tick_model_t *model) {
    const arm_ik_t *generated[] = {&arm_ik_hoap3_right, &arm_ik_six, &arm_ik_seven};
    for (int i = 0; model->name != NULL && i < 3; i++) {
        if (strcmp(generated[i]->arm->name, model->name) == 0) {
            self->ik = *generated[i];
            return;
        }
    }
    if (model->name != NULL) {
        abort(); /* unknown name: without this, the general code would be measured and reported as this arm's */
    }
    for (int i = 0; i < model->joint_count; i++) {
        self->joints[i] = (arm_joint_t){.fixed = pose(&model->fixed[7 * i]), .axis = {0.0f, 0.0f, 1.0f}};
    }
    self->arm = (arm_t){.joint_count = (uint8_t)model->joint_count,
                        .drive_lag_max_s = 0.013f,
                        .joints = self->joints,
                        .effector = pose(&model->fixed[7 * model->joint_count]),
                        .forward_kinematics = arm_forward_kinematics};
    self->ik = arm_ik_any(&self->arm);
}

tick_t *tick_create(const tick_model_t *model) {
    tick_t *self = calloc(1, sizeof *self + (size_t)model->hand_count * sizeof self->hand[0]);
    choose_arm(self, model);
    for (int i = 0; i < 8; i++) {
        self->config.weight[i] = (float)model->weight[i / 4];
        self->config.gain_per_s[i] = (float)model->gain_per_s[i / 4];
    }
    self->config.damping = (float)model->damping;
    self->config.error_frame = ERROR_FRAME_TARGET;
    differential_ik_prepare(&self->config);
    self->hand_count = model->hand_count;
    for (int i = 0; i < model->hand_count; i++) {
        self->hand[i] = pose(&model->hands[7 * i]);
    }
    tick_set(self, model->start_rad);
    const cooperation_config_t config = {.tracker_rotation = quaternion_identity, .motion_scale = 1.0f};
    cooperation_start(&self->cooperation, &config, &task_table[TASK_POUR], self->hand[0],
                      self->ik.arm->forward_kinematics(self->ik.arm, self->position_rad));
    return self;
}

void tick_set(tick_t *self, const double position_rad[]) {
    for (int i = 0; i < self->ik.arm->joint_count; i++) {
        self->position_rad[i] = (float)position_rad[i];
    }
}

static void tick(tick_t *self, int hand) {
    cooperation_update(&self->cooperation, &self->hand[hand], 1.0f);
    const differential_ik_request_t request = {.position_rad = self->position_rad, .target = &self->cooperation.target};
    arm_ik_differential(&self->ik, &self->config, &request, self->velocity_radps);
}

void tick_run(tick_t *self, int count) {
    for (int k = 0, hand = 0; k < count; k++, hand = hand + 1 == self->hand_count ? 0 : hand + 1) {
        tick(self, hand);
        for (int i = 0; i < self->ik.arm->joint_count; i++) {
            self->position_rad[i] += TICK_S * self->velocity_radps[i];
        }
    }
}

void tick_once(tick_t *self, int hand, double velocity_radps[]) {
    tick(self, hand);
    for (int i = 0; i < self->ik.arm->joint_count; i++) {
        velocity_radps[i] = (double)self->velocity_radps[i];
    }
}
