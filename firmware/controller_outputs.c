/* Sends the frames of a tick: see controller_outputs.h. */
#include "controller_outputs.h"

#include "comanip_dbc.h"

void controller_send(controller_t *self, can_frame_t *frame, controller_outbox_t *outbox) {
    (void)transport_send(&self->sender, frame, &outbox->sink);
}

/* ---- answers */

void controller_send_ack(controller_t *self, uint8_t command, uint8_t sequence, result_t result,
                         controller_outbox_t *outbox) {
    can_frame_t frame;
    (void)command_ack_pack(&(command_ack_t){.command = command, .sequence = sequence, .result = result}, &frame);
    controller_send(self, &frame, outbox);
}

void controller_send_parameter(controller_t *self, uint8_t parameter, uint8_t sequence, result_t result,
                               controller_outbox_t *outbox) {
    can_frame_t frame;
    parameter_value_t message = {
        .parameter = parameter,
        .sequence = sequence,
        .result = result,
        .value = parameter < PARAMETER_COUNT ? self->parameters.value[parameter] : 0.0f,
    };
    (void)parameter_value_pack(&message, &frame);
    controller_send(self, &frame, outbox);
}

/* ---- sent in each tick */

static void send_joint_command(controller_t *self, controller_outbox_t *outbox) {
    /* The brakes engage only after the arm has stopped. */
    bool moving = supervisor_is_engaged(&self->supervisor) || !joint_limits_at_rest(&self->limits, self->arm);
    outbox->enable_drives = moving || self->moving;
    self->moving = moving;
    joint_cmd_t command = {0}; /* braked */
    for (int i = 0; i < self->arm->joint_count; i++) {
        command.mode[i] = moving ? DRIVE_MODE_VELOCITY : DRIVE_MODE_BRAKE;
        command.position_rad[i] = self->limits.position_rad[i];
        command.velocity_radps[i] = self->limits.velocity_radps[i];
    }
    can_frame_t frame;
    if (joint_cmd_pack(&command, &frame) == PROTOCOL_OK) {
        joint_watch_command(&self->joint_watch, &command, outbox->enable_drives);
        controller_send(self, &frame, outbox);
    } else {
        self->finite = false; /* cannot happen: arm_check() ensures that all values within the limits fit the frame */
    }
}

static const pose_t no_target = {{0.0f, 0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}};

static void send_trace(controller_t *self, uint32_t now_us, controller_outbox_t *outbox) {
    tick_trace_t trace; /* has no initialiser, which would first write zeros: every member is set below */
    trace.now_us = now_us;
    trace.target_valid = self->supervisor.mode == MODE_COOPERATING;
    trace.target = trace.target_valid ? self->cooperation.target : no_target;
    const uint32_t age_us = hand_tracker_age_us(&self->hand_tracker, now_us);
    trace.hand_age_us = age_us < TRACE_AGE_MAX_US ? age_us : TRACE_AGE_MAX_US;
    trace.drives_fresh = self->supervisor_inputs.joints.finding != JOINT_WATCH_SILENT;
    trace.rejected_frames = (uint8_t)self->receiver.protocol.rejected;
    protocol_trace_inputs(self->receiver.protocol.e2e, &trace);
    can_frame_t frame;
    (void)tick_trace_pack(&trace, &frame);
    controller_send(self, &frame, outbox);
}

/* ---- sent periodically */

static void send_status(controller_t *self, controller_outbox_t *outbox) {
    firmware_status_t status = {
        .mode = self->supervisor.mode,
        .reason = self->supervisor.reason,
        .stop_category = supervisor_stop_category(&self->supervisor),
        .task = self->task_id,
        .latched = supervisor_is_engaged(&self->supervisor) && self->cooperation.latched,
        .rest_not_assured = self->parameter_set.verdict != PARAMETER_SET_RESTS,
        .changes_posture = posture_change_is_moving(&self->posture_change),
        .speed_limit_percent = 100.0f * self->parameters.value[PARAMETER_SPEED_FRACTION],
        .rejected_frames = (uint8_t)self->receiver.protocol.rejected,
    };
    can_frame_t frame;
    (void)firmware_status_pack(&status, &frame);
    controller_send(self, &frame, outbox);
}

static void send_port_status(controller_t *self, const port_status_t *port, controller_outbox_t *outbox) {
    can_frame_t frame;
    (void)port_status_pack(port, &frame);
    controller_send(self, &frame, outbox);
}

static void send_heartbeat(controller_t *self, controller_outbox_t *outbox) {
    heartbeat_state_t state = self->announced == 0u                 ? HEARTBEAT_BOOT_UP
                              : self->supervisor.mode == MODE_FAULT ? HEARTBEAT_STOPPED
                              : self->supervisor.mode == MODE_IDLE  ? HEARTBEAT_PRE_OPERATIONAL
                                                                    : HEARTBEAT_OPERATIONAL;
    can_frame_t frame;
    (void)firmware_heartbeat_pack(&(firmware_heartbeat_t){state}, &frame);
    controller_send(self, &frame, outbox);
}

_Static_assert(COMANIP_PORT_STATUS_CYCLE_TIME_MS == COMANIP_FIRMWARE_HEARTBEAT_CYCLE_TIME_MS,
               "PortStatus is sent in the tick after each heartbeat");

/* Returns the time since the last tick in which a frame of this kind was due. */
static uint32_t phase_ms(const controller_t *self, frame_kind_t kind) {
    return self->tick * self->tick_ms % transport_period_ms(self->sender.profile, kind);
}

void controller_publish(controller_t *self, uint32_t now_us, const port_status_t *port, controller_outbox_t *outbox) {
    send_joint_command(self, outbox);
    if (self->parameters.value[PARAMETER_TRACE] > 0.0f) {
        send_trace(self, now_us, outbox);
    }
    if (phase_ms(self, FRAME_FIRMWARE_STATUS) == 0u) {
        send_status(self, outbox);
    }
    const uint32_t since_heartbeat_ms = phase_ms(self, FRAME_FIRMWARE_HEARTBEAT);
    if (since_heartbeat_ms == 0u) {
        send_heartbeat(self, outbox);
    } else if (since_heartbeat_ms == self->tick_ms) { /* one tick after the heartbeat, to spread the load */
        send_port_status(self, port, outbox);
    }
}
