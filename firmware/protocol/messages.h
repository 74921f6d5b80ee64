/* The messages of the bus in SI units. For each message X there are a struct X_t and the functions
 *
 *   protocol_status_t X_pack(const X_t *message, can_frame_t *frame);
 *   void X_unpack(const can_frame_t *frame, X_t *message);
 *
 * which are generated from firmware/schema/comanip.dbc. X_pack() sets id, length and data, and rounds to nearest. It
 * never saturates: for NaN, or a value outside its signal's range, it returns PROTOCOL_OUT_OF_RANGE, and the frame must
 * not be sent. The exception is a pose with a validity flag: it is marked invalid, and the frame may be sent.
 * X_unpack() expects a frame that protocol_check() has accepted. can_protocol.h adds end-to-end protection. */
#ifndef COMANIP_PROTOCOL_MESSAGES_H
#define COMANIP_PROTOCOL_MESSAGES_H

#include <stdbool.h>
#include <stdint.h>

#include "../maths/pose.h"
#include "can_frame.h"

typedef enum {
    PROTOCOL_INCOMPLETE = 1, /* on classic CAN, a part was accepted, but the message is not yet complete */
    PROTOCOL_OK = 0,
    PROTOCOL_UNKNOWN_ID = -1,
    PROTOCOL_WRONG_LENGTH = -2,
    PROTOCOL_NOT_AUTHENTIC = -3, /* wrong CRC, repetition or wrong sequence: see e2e.h */
    PROTOCOL_OUT_OF_RANGE = -4,
} protocol_status_t;

#include "comanip_messages.h"

#endif
