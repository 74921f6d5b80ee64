#include "observer.h"

#include <stdlib.h>
#include <string.h>

#define US_PER_TICK 1000u

static void on_status(observer_t *self, const can_frame_t *frame, int64_t end_ns) {
    firmware_status_t status;
    firmware_status_unpack(frame, &status);
    self->firmware_rejected += (uint8_t)(status.rejected_frames - self->firmware_rejected_last);
    self->firmware_rejected_last = status.rejected_frames;
    self->tick.mode = status.mode;
    const mode_change_t *last = self->mode_count > 0 ? &self->modes[self->mode_count - 1] : NULL;
    if (last != NULL && last->mode == status.mode && last->reason == status.reason) {
        return;
    }
    if (self->mode_count == self->mode_capacity) {
        const size_t capacity = self->mode_capacity > 0 ? 2 * self->mode_capacity : 16;
        mode_change_t *modes = realloc(self->modes, capacity * sizeof *modes);
        if (modes == NULL) {
            self->out_of_memory = true;
            return;
        }
        self->modes = modes;
        self->mode_capacity = capacity;
    }
    self->modes[self->mode_count++] = (mode_change_t){(double)end_ns * 1e-9, status.mode, status.reason};
}

static void on_trace(observer_t *self, const can_frame_t *frame) {
    tick_trace_t trace;
    tick_trace_unpack(frame, &trace);
    bus_delays_trace(&self->delays, &trace);
    const uint32_t tick_us = (uint32_t)((bus_epoch_ns(self->bus) + self->tick.time_ns) / 1000);
    const uint32_t age_ticks = (tick_us - trace.now_us) / US_PER_TICK;
    const bool is_of_a_tick = (tick_us - trace.now_us) % US_PER_TICK == 0 && age_ticks < self->target_ticks;
    self->tick.has_target = trace.target_valid && is_of_a_tick;
    if (!self->tick.has_target) {
        return;
    }
    self->tick.target_ns = self->tick.time_ns - (int64_t)age_ticks * US_PER_TICK * 1000;
    /* The target must be compared with the end effector at the target's own time. */
    self->tick.hand_at_target = self->past_hand[(self->ticks - age_ticks) % OBSERVER_PAST_TICKS];
    self->target_ticks_left = self->target_ticks;
    const quaternion_t r = quaternion_normalise(trace.target.rotation);
    const vector3_t t = trace.target.translation_m;
    self->tick.target =
        (rigid_pose_t){{(double)t.x, (double)t.y, (double)t.z}, {(double)r.w, (double)r.x, (double)r.y, (double)r.z}};
}

static void on_parameter(observer_t *self, const can_frame_t *frame) {
    parameter_value_t value;
    parameter_value_unpack(frame, &value);
    if (value.parameter < PARAMETER_COUNT) {
        self->parameter[value.parameter] = value.value; /* the current value, whether or not a write was accepted */
    }
}

static void on_define(observer_t *self, const can_frame_t *frame) {
    task_define_t define;
    task_define_unpack(frame, &define);
    self->defined_blend_s = (double)define.blend_s;
}

/* Handles an acknowledged command. A start restarts the blend of the selected task, a clutch continues it, and a latch
 * ends it. */
static void on_ack(observer_t *self, const can_frame_t *frame, int64_t end_ns) {
    command_ack_t ack;
    command_ack_unpack(frame, &ack);
    if (ack.result != RESULT_ACCEPTED || ack.command == COMMAND_STOP || ack.command == COMMAND_ACKNOWLEDGE) {
        return;
    }
    if (ack.command == COMMAND_SELECT) {
        self->blend_s = (double)self->parameter[PARAMETER_TASK_BLEND_S];
    } else if (ack.command == COMMAND_DEFINE) {
        self->blend_s = self->defined_blend_s;
    }
    const bool blends = ack.command != COMMAND_LATCH && ack.command != COMMAND_CLUTCH;
    if (!(ack.command == COMMAND_CLUTCH && self->settled_ns > end_ns)) {
        self->settled_ns = end_ns + (blends ? (int64_t)(self->blend_s * 1e9) : 0);
    }
}

static void on_pose(observer_t *self, const can_frame_t *frame, int64_t end_ns) {
    hand_pose_t pose;
    hand_pose_unpack(frame, &pose);
    bus_delays_pose(&self->delays, &pose, self->tracker_clock_us + (uint32_t)(end_ns / 1000));
}

static void on_tracker(observer_t *self, const can_frame_t *frame) {
    tracker_status_t status;
    tracker_status_unpack(frame, &status);
    bus_delays_tracker(&self->delays, &status);
}

static void on_message(observer_t *self, frame_kind_t kind, const can_frame_t *message, int64_t end_ns) {
    if (kind == FRAME_FIRMWARE_STATUS) {
        on_status(self, message, end_ns);
    } else if (kind == FRAME_TICK_TRACE) {
        on_trace(self, message);
    } else if (kind == FRAME_PARAMETER_VALUE) {
        on_parameter(self, message);
    } else if (kind == FRAME_HAND_POSE) {
        on_pose(self, message, end_ns);
    } else if (kind == FRAME_PORT_STATUS) {
        port_status_unpack(message, &self->port);
        self->has_port = true;
    } else if (kind == FRAME_TRACKER_STATUS) {
        on_tracker(self, message);
    } else if (kind == FRAME_TASK_DEFINE) {
        on_define(self, message);
    } else if (kind == FRAME_COMMAND_ACK) {
        on_ack(self, message, end_ns);
    } else if (kind == FRAME_JOINT_CMD) {
        joint_cmd_unpack(message, &self->tick.command);
        self->tick.has_command = true;
        bus_delays_command(&self->delays, (uint32_t)((bus_epoch_ns(self->bus) + end_ns) / 1000));
        limit_monitor_command(&self->limits, &self->tick.command, end_ns,
                              (double)self->parameter[PARAMETER_SPEED_FRACTION],
                              (double)self->parameter[PARAMETER_ACCELERATION_LIMIT_RADPS2]);
    } else if (kind >= FRAME_JOINT_STATE0 && kind < FRAME_JOINT_STATE0 + ROBOT_JOINTS) {
        joint_state_t state;
        joint_state_unpack(message, &state);
        self->tick.measured_rad[kind - FRAME_JOINT_STATE0] = (double)state.position_rad;
    }
}

static void on_frame(void *context, const can_frame_t *frame, int64_t end_ns) {
    observer_t *self = context;
    can_frame_t message = *frame;
    frame_kind_t kind;
    const protocol_status_t status = transport_receive(&self->receiver, &message, &kind);
    if (status == PROTOCOL_OK) {
        on_message(self, kind, &message, end_ns);
    } else if (status != PROTOCOL_UNKNOWN_ID && status != PROTOCOL_INCOMPLETE && kind == FRAME_JOINT_CMD) {
        limit_monitor_undecodable(&self->limits, end_ns);
    }
}

void observer_init(observer_t *self, bus_t *bus, uint32_t tracker_clock_us) {
    memset(self, 0, sizeof *self);
    self->tracker_clock_us = tracker_clock_us;
    self->bus = bus;
    for (int i = 0; i < PARAMETER_COUNT; i++) {
        self->parameter[i] = parameter_table[i].default_value;
    }
    limit_monitor_init(&self->limits);
    const can_profile_t profile = bus_profile(bus);
    transport_receiver_init(&self->receiver, profile, ROBOT_JOINTS, TRANSPORT_ALL_KINDS);
    self->target_ticks = 2u * transport_period_ms(profile, FRAME_TICK_TRACE) - 1u;
    bus_listen(bus, on_frame, self);
}

void observer_free(observer_t *self) {
    free(self->modes);
    self->modes = NULL;
}

void observer_begin_tick(observer_t *self, int64_t time_ns, const rigid_pose_t *hand) {
    self->tick.time_ns = time_ns;
    self->tick.hand = *hand;
    self->past_hand[++self->ticks % OBSERVER_PAST_TICKS] = *hand;
    self->target_ticks_left -= self->target_ticks_left > 0;
    self->tick.has_target = self->tick.has_target && self->target_ticks_left > 0;
    self->tick.has_command = false;
}
