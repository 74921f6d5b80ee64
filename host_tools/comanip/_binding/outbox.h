/* Stores the frames that the firmware sends in a tick, for Python and for the replay. */
#ifndef COMANIP_OUTBOX_H
#define COMANIP_OUTBOX_H

#include "../../../firmware/controller.h"

typedef struct {
    can_frame_t frame[CONTROLLER_OUTBOX_FRAMES];
    uint8_t count;
    bool save, enable_drives; /* as in controller_outbox_t */
} outbox_t;

/* Runs controller_step() and stores the frames that it sends. */
void outbox_step(outbox_t *self, controller_t *controller, uint32_t now_us, controller_inbox_t *inbox);

/* Runs transport_send() and stores the frames of the message in `frame`, which must have room for TRANSPORT_MAX_FRAMES.
 * Returns the number of frames, or 0 if the message cannot be sent. */
uint8_t outbox_frames(transport_sender_t *sender, const can_frame_t *message, can_frame_t frame[]);

#endif
