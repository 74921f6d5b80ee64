/* Runs the firmware against a kinematic arm: see kinematic_loop.h. */
#include "kinematic_loop.h"

#include <math.h>
#include <string.h>

#define TICK_US 1000u
#define TICK_S 1e-3
#define PULSES_PER_RAD (209.0 * 180.0 / 3.14159265358979324) /* resolution of HOAP-3's encoders */
#define JOINT_STATE_US 440u /* delay from the tick to the first drive's answer, as on the simulated bus */
#define JOINT_STATE_SPACING_US 57u
#define STATUS_PERIOD_TICKS 100u
#define SELECT_BEFORE_START_TICKS 10u

/* ---- the arm */

void kinematic_arm_init(kinematic_arm_t *self, int joint_count, double lag_s, const double start_rad[]) {
    *self = (kinematic_arm_t){.joint_count = joint_count, .lag_s = lag_s};
    memcpy(self->position_rad, start_rad, (size_t)joint_count * sizeof start_rad[0]);
}

void kinematic_arm_step(kinematic_arm_t *self, const float command_radps[], float encoder_rad[]) {
    const double share = 1.0 - exp(-TICK_S / self->lag_s);
    for (int i = 0; i < self->joint_count; i++) {
        encoder_rad[i] = (float)(nearbyint(self->position_rad[i] * PULSES_PER_RAD) / PULSES_PER_RAD);
        self->velocity_radps[i] += ((double)command_radps[i] - self->velocity_radps[i]) * share;
        self->position_rad[i] += self->velocity_radps[i] * TICK_S;
    }
}

/* ---- the firmware in a loop with the arm */

typedef struct {
    const kinematic_loop_config_t *config;
    controller_t controller;
    controller_inbox_t inbox;
    uint32_t received_us;      /* time of reception of the frame that is being sent to the firmware */
    transport_sender_t others; /* sender for tracker, drives and operator; they can share one because no two of them
                                * send the same frame */
    joint_cmd_t command;
    bool accepted; /* no frame or request has been refused so far */
} loop_t;

static void to_firmware(void *context, const can_frame_t *frame) {
    loop_t *self = context;
    self->accepted = self->accepted && self->inbox.count < CONTROLLER_INBOX_FRAMES;
    if (self->accepted) {
        can_frame_t *received = &self->inbox.frame[self->inbox.count++];
        *received = *frame;
        received->timestamp_us = self->received_us;
    }
}

static void send(loop_t *self, can_frame_t *frame, uint32_t received_us) {
    const can_sink_t sink = {to_firmware, self};
    self->received_us = received_us;
    self->accepted = transport_send(&self->others, frame, &sink) && self->accepted;
}

static void from_firmware(void *context, const can_frame_t *frame) {
    loop_t *self = context;
    if (frame->id == frame_table[FRAME_JOINT_CMD].id) {
        joint_cmd_unpack(frame, &self->command);
    } else if (frame->id == frame_table[FRAME_COMMAND_ACK].id) {
        command_ack_t ack;
        command_ack_unpack(frame, &ack);
        self->accepted = self->accepted && ack.result == RESULT_ACCEPTED;
    }
}

static void send_status(loop_t *self, uint32_t now_us) {
    const tracker_status_t status = {
        .t_us = now_us, .period_us = self->config->period_us, .latency_us = self->config->latency_us};
    can_frame_t frame;
    (void)tracker_status_pack(&status, &frame);
    send(self, &frame, now_us);
}

static void send_command(loop_t *self, command_t command, uint32_t now_us) {
    can_frame_t frame;
    (void)operator_command_pack(
        &(operator_command_t){.command = (uint8_t)command, .sequence = (uint8_t)command, .task = self->config->task},
        &frame);
    send(self, &frame, now_us);
}

static void send_joint_states(loop_t *self, const kinematic_arm_t *arm, const float encoder_rad[], uint32_t tick_us) {
    for (int i = 0; i < arm->joint_count; i++) {
        const joint_state_t state = {.position_rad = encoder_rad[i],
                                     .velocity_radps = (float)arm->velocity_radps[i],
                                     .mode = self->command.mode[i]};
        can_frame_t frame;
        (void)joint_state_pack(i, &state, &frame);
        send(self, &frame, tick_us + JOINT_STATE_US + (uint32_t)i * JOINT_STATE_SPACING_US);
    }
}

static void init(loop_t *self, const kinematic_loop_config_t *config) {
    *self = (loop_t){.config = config, .accepted = true};
    controller_init(&self->controller, config->ik, CAN_PROFILE_FD);
    controller_set_parameters(&self->controller, &config->parameters, RESULT_ACCEPTED);
    transport_sender_init(&self->others, CAN_PROFILE_FD, config->ik->arm->joint_count);
}

bool kinematic_loop_run(const kinematic_loop_config_t *config, const double start_rad[], size_t sample_count,
                        const kinematic_sample_t samples[], size_t tick_count, kinematic_tick_t ticks[]) {
    loop_t loop;
    init(&loop, config);
    controller_outbox_t outbox = {.sink = {from_firmware, &loop}};
    kinematic_arm_t arm;
    kinematic_arm_init(&arm, config->ik->arm->joint_count, config->lag_s, start_rad);
    size_t next_sample = 0;
    for (uint32_t k = 0; k < tick_count && loop.accepted; k++) {
        const uint32_t now_us = k * TICK_US;
        for (; next_sample < sample_count && samples[next_sample].received_us <= now_us; next_sample++) {
            can_frame_t frame;
            (void)hand_pose_pack(&samples[next_sample].pose, &frame);
            send(&loop, &frame, samples[next_sample].received_us);
        }
        if (k % STATUS_PERIOD_TICKS == 0u) {
            send_status(&loop, now_us);
        }
        if (k + SELECT_BEFORE_START_TICKS == config->start_tick) {
            send_command(&loop, COMMAND_SELECT, now_us);
        } else if (k == config->start_tick) {
            send_command(&loop, COMMAND_START, now_us);
        }
        controller_step(&loop.controller, now_us, &loop.inbox, &outbox);
        loop.inbox.count = 0;

        kinematic_tick_t *tick = &ticks[k];
        *tick = (kinematic_tick_t){.mode = loop.controller.supervisor.mode};
        memcpy(tick->position_rad, arm.position_rad, sizeof tick->position_rad);
        for (int i = 0; i < arm.joint_count; i++) {
            tick->command_radps[i] =
                loop.command.mode[i] == DRIVE_MODE_VELOCITY ? loop.command.velocity_radps[i] : 0.0f;
        }
        float encoder_rad[ARM_MAX_JOINTS];
        kinematic_arm_step(&arm, tick->command_radps, encoder_rad);
        send_joint_states(&loop, &arm, encoder_rad, now_us);
    }
    return loop.accepted;
}
