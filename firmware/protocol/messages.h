/* The messages of the bus in SI units: a struct for each, X_t, and
 *
 *   protocol_status_t X_pack(const X_t *message, can_frame_t *frame);
 *   void X_unpack(const can_frame_t *frame, X_t *message);
 *
 * generated from firmware/schema/comanip.dbc. pack sets id, length and data and rounds to nearest. A value out of its
 * signal's range (or NaN) is never saturated: pack returns PROTOCOL_OUT_OF_RANGE, and the frame must not be sent. A
 * pose with a validity flag is an exception: it becomes invalid, and the frame may be sent. unpack expects a frame that
 * protocol_check() accepted. can_protocol.h adds end-to-end protection. */
#ifndef COMANIP_PROTOCOL_MESSAGES_H
#define COMANIP_PROTOCOL_MESSAGES_H

#include <stdbool.h>
#include <stdint.h>

#include "../maths/pose.h"
#include "can_frame.h"

typedef enum {
    PROTOCOL_INCOMPLETE = 1, /* classic CAN: a part was accepted, the message is not yet complete */
    PROTOCOL_OK = 0,
    PROTOCOL_UNKNOWN_ID = -1,
    PROTOCOL_WRONG_LENGTH = -2,
    PROTOCOL_NOT_AUTHENTIC = -3, /* CRC, repetition or sequence: see e2e.h */
    PROTOCOL_OUT_OF_RANGE = -4,
} protocol_status_t;

#include "comanip_messages.h"

#endif
