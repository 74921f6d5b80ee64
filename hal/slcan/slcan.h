/* SLCAN: CAN frames as lines of text on a serial line (Lawicel's ASCII protocol, extended by the CAN FD letters of the
 * CANable 2 firmware). This code is portable: the ports without a CAN controller share it, and the tests use it.
 *
 *   tIIIL...   classic frame        dIIIL...   FD frame        bIIIL...   FD frame with bit-rate switch
 *
 * III is the 11-bit id and L the data length code, in hexadecimal digits (9..F = 12, 16, 20, 24, 32, 48, 64 bytes, FD
 * only). Two digits per byte follow, then CR. Hexadecimal digits are accepted in lower and upper case, and written in
 * upper case; FD frames are written with b. T, D and B (29-bit ids), r and R (remote frames) and the adapter's
 * channel commands (O, C, S8, Y5, ...) are ignored. */
#ifndef COMANIP_SLCAN_H
#define COMANIP_SLCAN_H

#include <stddef.h>
#include <stdint.h>

#include "../../firmware/protocol/can_frame.h"

#define SLCAN_LINE_MAX_BYTES (1 + 3 + 1 + 2 * CAN_FRAME_MAX_BYTES + 1)

/* Writes the frame's line, including the CR, without a terminating zero. Returns the line's length, or 0 if the id has
 * more than 11 bits or no frame of this kind (classic or FD) can have this length. */
size_t slcan_encode(const can_frame_t *frame, char line[SLCAN_LINE_MAX_BYTES]);

typedef enum {
    SLCAN_PENDING,   /* the line is not yet complete */
    SLCAN_FRAME,     /* the line is complete, and the frame is valid */
    SLCAN_IGNORED,   /* the line is complete, but is empty or a kind of SLCAN line that this bus does not use */
    SLCAN_MALFORMED, /* the line is complete, but is not valid SLCAN */
} slcan_event_t;

typedef enum {
    SLCAN_STATE_START,
    SLCAN_STATE_ID,
    SLCAN_STATE_LENGTH,
    SLCAN_STATE_DATA,
    SLCAN_STATE_COMPLETE,
    SLCAN_STATE_IGNORE,
    SLCAN_STATE_MALFORMED,
} slcan_state_t;

/* Zero-initialise. */
typedef struct {
    slcan_state_t state;
    uint8_t max_length_code; /* 8 for classic, 15 for FD */
    uint8_t digits;          /* number of digits received so far of the current field */
} slcan_decoder_t;

/* Decodes the next byte of the line. This takes only a few tens of instructions, few enough for the receive interrupt
 * of a UART that buffers only one byte. frame: must be the same for all bytes of a line; id, length and data are
 * valid only when SLCAN_FRAME is returned, and the caller must set the timestamp. */
slcan_event_t slcan_decode(slcan_decoder_t *self, uint8_t byte, can_frame_t *frame);

/* Call this when bytes were lost: the current line is then treated as malformed. */
void slcan_spoil(slcan_decoder_t *self);

#endif
