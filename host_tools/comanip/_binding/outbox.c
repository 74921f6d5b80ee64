/* Stores the frames that the firmware sends: see outbox.h. */
#include "outbox.h"

static void append(void *context, const can_frame_t *frame) {
    can_frame_t **next = context;
    *(*next)++ = *frame;
}

void outbox_step(outbox_t *self, controller_t *controller, uint32_t now_us, controller_inbox_t *inbox) {
    can_frame_t *next = self->frame;
    controller_outbox_t outbox = {.sink = {append, &next}};
    controller_step(controller, now_us, inbox, &outbox);
    self->count = (uint8_t)(next - self->frame);
    self->save = outbox.save;
    self->enable_drives = outbox.enable_drives;
}

uint8_t outbox_frames(transport_sender_t *sender, const can_frame_t *message, can_frame_t frame[]) {
    can_frame_t copy = *message, *next = frame;
    (void)transport_send(sender, &copy, &(can_sink_t){append, &next});
    return (uint8_t)(next - frame);
}
