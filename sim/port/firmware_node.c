#include "firmware_node.h"

static void on_frame(void *context, const can_frame_t *frame, int64_t end_ns) {
    firmware_node_t *self = context;
    (void)end_ns; /* the frame carries its own timestamp, as from a CAN controller */
    if (self->count == FIRMWARE_NODE_QUEUE_FRAMES) {
        self->world->firmware_overflows++;
        return;
    }
    self->queue[(self->first + self->count) % FIRMWARE_NODE_QUEUE_FRAMES] = *frame;
    self->count++;
}

void firmware_node_attach(firmware_node_t *self, world_t *world) {
    self->world = world;
    self->first = 0;
    self->count = 0;
    self->refused_frames = 0;
    self->node = bus_attach(world->bus, on_frame, self);
}

bool firmware_node_receive(firmware_node_t *self, can_frame_t *frame) {
    if (self->count == 0) {
        return false;
    }
    *frame = self->queue[self->first];
    self->first = (self->first + 1) % FIRMWARE_NODE_QUEUE_FRAMES;
    self->count--;
    return true;
}

bool firmware_node_send(firmware_node_t *self, const can_frame_t *frame) {
    const bool is_queued =
        bus_send(self->world->bus, self->node, frame, self->world->now_ns + FIRMWARE_NODE_COMPUTE_TIME_NS);
    self->refused_frames += !is_queued;
    return is_queued;
}
