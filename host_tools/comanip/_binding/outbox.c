#include "outbox.h"

static void keep(void *context, const can_frame_t *frame) {
    outbox_t *self = context;
    self->frame[self->count++] = *frame;
}

void outbox_step(outbox_t *self, controller_t *controller, uint32_t now_us, controller_inbox_t *inbox) {
    controller_outbox_t outbox = {.sink = {keep, self}};
    self->count = 0;
    controller_step(controller, now_us, inbox, &outbox);
    self->save = outbox.save;
}

static void append(void *context, const can_frame_t *frame) {
    can_frame_t **next = context;
    *(*next)++ = *frame;
}

uint8_t outbox_frames(transport_sender_t *sender, const can_frame_t *message, can_frame_t frame[]) {
    can_frame_t copy = *message, *next = frame;
    (void)transport_send(sender, &copy, &(can_sink_t){append, &next});
    return (uint8_t)(next - frame);
}
