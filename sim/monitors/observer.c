#include "observer.h"

#include <stdlib.h>
#include <string.h>

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
    /* Only the target of this very tick may be compared with the hand of this tick. */
    const uint32_t tick_us = (uint32_t)((bus_epoch_ns(self->bus) + self->tick.time_ns) / 1000);
    if (!trace.target_valid || trace.now_us != tick_us) {
        return;
    }
    const quaternion_t r = trace.target.primary;
    const vector3_t t = dual_quaternion_translation(trace.target);
    self->tick.has_target = true;
    self->tick.target = (rigid_pose_t){{(double)t.x, (double)t.y, (double)t.z},
                                       {(double)r.w, (double)r.x, (double)r.y, (double)r.z}};
}

static void on_parameter(observer_t *self, const can_frame_t *frame) {
    parameter_value_t value;
    parameter_value_unpack(frame, &value);
    if (value.parameter < PARAMETER_COUNT) {
        self->parameter[value.parameter] = value.value; /* the one in force, whatever the result */
    }
}

static void on_frame(void *context, const can_frame_t *frame, int64_t end_ns) {
    observer_t *self = context;
    frame_kind_t kind;
    if (protocol_check(&self->receiver, frame, &kind) != PROTOCOL_OK) {
        if (frame->id == frame_table[FRAME_JOINT_CMD].id) {
            limit_monitor_undecodable(&self->limits, end_ns);
        }
        return;
    }
    if (kind == FRAME_FIRMWARE_STATUS) {
        on_status(self, frame, end_ns);
    } else if (kind == FRAME_TICK_TRACE) {
        on_trace(self, frame);
    } else if (kind == FRAME_PARAMETER_VALUE) {
        on_parameter(self, frame);
    } else if (kind == FRAME_JOINT_CMD) {
        joint_command_unpack(frame, &self->tick.command);
        self->tick.has_command = true;
        limit_monitor_command(&self->limits, &self->tick.command, end_ns,
                              (double)self->parameter[PARAMETER_SPEED_FRACTION],
                              (double)self->parameter[PARAMETER_ACCELERATION_LIMIT_RADPS2]);
    } else if (kind >= FRAME_JOINT_STATE0 && kind < FRAME_JOINT_STATE0 + ROBOT_JOINTS) {
        joint_state_t state;
        joint_state_unpack(frame, &state);
        self->tick.measured_rad[kind - FRAME_JOINT_STATE0] = (double)state.position_rad;
    }
}

void observer_init(observer_t *self, bus_t *bus) {
    memset(self, 0, sizeof *self);
    self->bus = bus;
    for (int i = 0; i < PARAMETER_COUNT; i++) {
        self->parameter[i] = parameter_table[i].default_value;
    }
    limit_monitor_init(&self->limits);
    bus_listen(bus, on_frame, self);
}

void observer_free(observer_t *self) {
    free(self->modes);
    self->modes = NULL;
}

void observer_begin_tick(observer_t *self, int64_t time_ns, const rigid_pose_t *hand) {
    self->tick.time_ns = time_ns;
    self->tick.hand = *hand;
    self->tick.has_target = false;
    self->tick.has_command = false;
}
