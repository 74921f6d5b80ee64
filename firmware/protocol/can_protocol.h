/* The frames of the bus on CAN FD: identification, end-to-end protection and its check. messages.h defines their
 * contents. Nodes use can_transport.h, which also works on classic CAN:
 *
 *   sending:   X_pack(&message, &frame); transport_send(&sender, &frame, ...);
 *   receiving: if (transport_receive(&receiver, &frame, &kind) == PROTOCOL_OK) X_unpack(&frame, &message); */
#ifndef COMANIP_CAN_PROTOCOL_H
#define COMANIP_CAN_PROTOCOL_H

#include <stdbool.h>
#include <stdint.h>

#include "can_frame.h"
#include "e2e.h"
#include "frame_table.h"
#include "messages.h"

/* State of a sender: the next counter of each frame. Zero-initialise. */
typedef struct {
    uint8_t counter[FRAME_KIND_COUNT];
} protocol_sender_t;

/* State of a receiver. Zero-initialise. */
typedef struct {
    e2e_receiver_t e2e[FRAME_KIND_COUNT];
    uint32_t rejected; /* number of refused frames */
} protocol_receiver_t;

/* Finds the kind of the frame with this id. Returns false if the id belongs to another system on the same bus; *kind is
 * then undefined. */
bool protocol_find(uint16_t id, frame_kind_t *kind);

/* Adds end-to-end protection. Leaves frames of other systems unchanged. */
void protocol_protect(protocol_sender_t *self, can_frame_t *frame);

/* Checks the length, CRC and counter of a received frame. For an event message, every counter except a repeated one is
 * accepted, because the sender may have restarted. Every refused frame is counted. */
protocol_status_t protocol_check(protocol_receiver_t *self, const can_frame_t *frame, frame_kind_t kind);

/* ---- the input of a tick, as recorded in TickTrace */

#define TRACE_AGE_MAX_US 0xFFFFFFu /* largest value of hand_age_us (24 bits); also sent if there is no pose */

/* Convert between the input frames and their record in a TickTrace. last: for each frame kind, the counter of the last
 * frame received with a correct CRC. */
void protocol_trace_inputs(const e2e_receiver_t last[FRAME_KIND_COUNT], tick_trace_t *trace);
void protocol_traced_inputs(const tick_trace_t *trace, e2e_receiver_t last[FRAME_KIND_COUNT]);

#endif
