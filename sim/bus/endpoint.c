#include "endpoint.h"

#include <stddef.h>

#include "../robot/robot_model.h"

static void on_frame(void *context, const can_frame_t *frame, int64_t end_ns) {
    endpoint_t *self = context;
    can_frame_t message = *frame;
    frame_kind_t kind;
    if (transport_receive(&self->receiver, &message, &kind) == PROTOCOL_OK) {
        self->handler(self->context, kind, &message, end_ns);
    }
}

void endpoint_attach(endpoint_t *self, bus_t *bus, uint32_t kinds, endpoint_handler_t handler, void *context) {
    const can_profile_t profile = bus_profile(bus);
    self->bus = bus;
    self->handler = handler;
    self->context = context;
    transport_sender_init(&self->sender, profile, ROBOT_JOINTS);
    transport_receiver_init(&self->receiver, profile, ROBOT_JOINTS, kinds);
    self->node = bus_attach(bus, handler != NULL ? on_frame : NULL, self);
}

void endpoint_send(endpoint_t *self, const can_frame_t *message, int64_t ready_ns) {
    can_frame_t frame[TRANSPORT_MAX_FRAMES];
    const uint8_t frames = transport_send(&self->sender, message, frame);
    for (uint8_t i = 0; i < frames; i++) {
        (void)bus_send(self->bus, self->node, &frame[i], ready_ns);
    }
}

uint32_t endpoint_rejected(const endpoint_t *self) {
    return self->receiver.protocol.rejected;
}
