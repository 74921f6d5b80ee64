#include "endpoint.h"

#include <stddef.h>

static void on_frame(void *context, const can_frame_t *frame, int64_t end_ns) {
    endpoint_t *self = context;
    can_frame_t message = *frame;
    frame_kind_t kind;
    if (transport_receive(&self->receiver, &message, &kind) == PROTOCOL_OK) {
        self->handler(self->context, kind, &message, end_ns);
    }
}

void endpoint_attach(endpoint_t *self, bus_t *bus, uint8_t joint_count, uint32_t kinds, endpoint_handler_t handler,
                     void *context) {
    const can_profile_t profile = bus_profile(bus);
    self->bus = bus;
    self->handler = handler;
    self->context = context;
    transport_sender_init(&self->sender, profile, joint_count);
    transport_receiver_init(&self->receiver, profile, joint_count, kinds);
    self->node = bus_attach(bus, handler != NULL ? on_frame : NULL, self);
}

static void on_bus(void *context, const can_frame_t *frame) {
    const endpoint_t *self = context;
    (void)bus_send(self->bus, self->node, frame, self->ready_ns);
}

void endpoint_send(endpoint_t *self, const can_frame_t *message, int64_t ready_ns) {
    can_frame_t frame = *message;
    self->ready_ns = ready_ns;
    (void)transport_send(&self->sender, &frame, &(can_sink_t){on_bus, self});
}

uint32_t endpoint_rejected(const endpoint_t *self) {
    return self->receiver.protocol.rejected;
}
