/* Converts SLCAN lines to frames and back. */
#include "slcan.h"

#define STANDARD_ID_MAX 0x7FFu
#define ID_DIGITS 3u
#define LENGTH_CODE_COUNT 16u
#define CLASSIC_MAX_LENGTH_CODE 8u

static const uint8_t length_of_code[LENGTH_CODE_COUNT] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64};

static char digit_of(unsigned value) {
    return "0123456789ABCDEF"[value & 0xFu];
}

/* Returns the value of a hexadecimal digit, or -1 for any other byte. */
static int value_of(uint8_t digit) {
    if (digit >= '0' && digit <= '9') {
        return digit - '0';
    }
    if (digit >= 'A' && digit <= 'F') {
        return digit - 'A' + 10;
    }
    if (digit >= 'a' && digit <= 'f') {
        return digit - 'a' + 10;
    }
    return -1;
}

size_t slcan_encode(const can_frame_t *frame, char line[SLCAN_LINE_MAX_BYTES]) {
    unsigned code = 0;
    while (code < LENGTH_CODE_COUNT && length_of_code[code] != frame->length) {
        code++;
    }
    if (code > (frame->fd ? LENGTH_CODE_COUNT - 1u : CLASSIC_MAX_LENGTH_CODE) || frame->id > STANDARD_ID_MAX) {
        return 0;
    }
    size_t n = 0;
    line[n++] = frame->fd ? 'b' : 't';
    line[n++] = digit_of(frame->id >> 8u);
    line[n++] = digit_of(frame->id >> 4u);
    line[n++] = digit_of(frame->id);
    line[n++] = digit_of(code);
    for (unsigned i = 0; i < frame->length; i++) {
        line[n++] = digit_of(frame->data[i] >> 4u);
        line[n++] = digit_of(frame->data[i]);
    }
    line[n++] = '\r';
    return n;
}

/* Returns the state after this first letter of a line. */
static slcan_state_t begin(slcan_decoder_t *self, uint8_t letter) {
    self->digits = 0;
    switch (letter) {
    case 't': self->max_length_code = CLASSIC_MAX_LENGTH_CODE; return SLCAN_STATE_ID;
    case 'd':
    case 'b': self->max_length_code = LENGTH_CODE_COUNT - 1; return SLCAN_STATE_ID;
    case '\a': /* an adapter's error reply, a whole line without CR */ return SLCAN_STATE_START;
    case 'T':
    case 'D':
    case 'B':
    case 'r':
    case 'R':
    case 'O': /* open, close, listen only */
    case 'C':
    case 'L':
    case 'S': /* bit rates */
    case 's':
    case 'Y':
    case 'y':
    case 'M': /* silent mode, filter */
    case 'm':
    case 'A': /* automatic retransmission */
    case 'E': /* error register, flags, version, serial number, timestamps */
    case 'F':
    case 'V':
    case 'v':
    case 'N':
    case 'Z':
    case 'z': /* z and Z are also an adapter's acknowledgements */ return SLCAN_STATE_IGNORE;
    default: return SLCAN_STATE_MALFORMED;
    }
}

static slcan_state_t take_digit(slcan_decoder_t *self, unsigned value, can_frame_t *frame) {
    switch (self->state) {
    case SLCAN_STATE_ID:
        frame->fd = self->max_length_code > CLASSIC_MAX_LENGTH_CODE;
        frame->id = (uint16_t)((self->digits == 0 ? 0u : (unsigned)frame->id << 4u) | value);
        self->digits++;
        if (self->digits < ID_DIGITS) {
            return SLCAN_STATE_ID;
        }
        self->digits = 0;
        return frame->id > STANDARD_ID_MAX ? SLCAN_STATE_MALFORMED : SLCAN_STATE_LENGTH;
    case SLCAN_STATE_LENGTH:
        if (value > self->max_length_code) {
            return SLCAN_STATE_MALFORMED;
        }
        frame->length = length_of_code[value];
        return frame->length == 0 ? SLCAN_STATE_COMPLETE : SLCAN_STATE_DATA;
    case SLCAN_STATE_DATA: {
        uint8_t *byte = &frame->data[self->digits / 2u];
        *byte = (uint8_t)(self->digits % 2u == 0 ? value << 4u : *byte | value);
        self->digits++;
        return self->digits == 2u * frame->length ? SLCAN_STATE_COMPLETE : SLCAN_STATE_DATA;
    }
    default: /* more digits than the length code announced */ return SLCAN_STATE_MALFORMED;
    }
}

static slcan_event_t finish(slcan_decoder_t *self) {
    slcan_state_t last = self->state;
    self->state = SLCAN_STATE_START;
    switch (last) {
    case SLCAN_STATE_COMPLETE: return SLCAN_FRAME;
    case SLCAN_STATE_START: /* an empty line is an adapter's acknowledgement */
    case SLCAN_STATE_IGNORE: return SLCAN_IGNORED;
    default: return SLCAN_MALFORMED;
    }
}

slcan_event_t slcan_decode(slcan_decoder_t *self, uint8_t byte, can_frame_t *frame) {
    if (byte == '\r') {
        return finish(self);
    }
    if (self->state == SLCAN_STATE_START) {
        self->state = begin(self, byte);
    } else if (self->state != SLCAN_STATE_IGNORE && self->state != SLCAN_STATE_MALFORMED) {
        int value = value_of(byte);
        self->state = value < 0 ? SLCAN_STATE_MALFORMED : take_digit(self, (unsigned)value, frame);
    }
    return SLCAN_PENDING;
}

void slcan_spoil(slcan_decoder_t *self) {
    self->state = SLCAN_STATE_MALFORMED;
}
