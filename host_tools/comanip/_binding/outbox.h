/* What the firmware sends, kept: for Python, and for the replay. */
#ifndef COMANIP_OUTBOX_H
#define COMANIP_OUTBOX_H

#include "../../../firmware/controller.h"

typedef struct {
    can_frame_t frame[CONTROLLER_OUTBOX_FRAMES];
    uint8_t count;
    bool save, enable_drives; /* as controller_outbox_t */
} outbox_t;

/* controller_step(), with the tick's frames in the outbox. */
void outbox_step(outbox_t *self, controller_t *controller, uint32_t now_us, controller_inbox_t *inbox);

/* transport_send(): the message's frames. Returns their number, 0 if it cannot be sent. frame: room for
 * TRANSPORT_MAX_FRAMES. */
uint8_t outbox_frames(transport_sender_t *sender, const can_frame_t *message, can_frame_t frame[]);

#endif
