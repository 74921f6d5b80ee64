#include "e2e.h"

#define COUNTER4_MASK 0x0Fu

/* A frame with a right CRC: is its counter the next one? */
static e2e_status_t follow(e2e_receiver_t *self, uint8_t counter, uint8_t mask, uint8_t max_delta) {
    uint8_t delta = (uint8_t)(counter - self->counter) & mask;
    bool first = !self->started;
    self->started = true;
    self->counter = counter;
    if (first || delta == 1u) {
        return E2E_OK;
    }
    if (delta == 0u) {
        return E2E_REPEATED;
    }
    return delta <= max_delta ? E2E_SOME_LOST : E2E_WRONG_SEQUENCE;
}

/* ---- Profile 5 */

/* CRC-16/CCITT of up to four more bytes, in the lower half of the result, without a table. With y(x) the remainder so far and the bytes,
 * y x^16 = q P + remainder, where the polynomial P = x^16 + x^12 + x^5 + 1. q is y + D y + D^2 y + ... with D y the part of
 * y (x^12 + x^5 + 1) that overflows 16 bits. That is (1 + D) (1 + D^2) (1 + D^4) y, and squares have no mixed terms modulo 2. */
static uint32_t crc16(uint32_t y) {
    uint32_t q = y ^ y >> 4 ^ y >> 11 ^ y >> 16;
    q ^= q >> 8 ^ q >> 22;
    q ^= q >> 16;
    return q ^ q << 5 ^ q << 12;
}

static uint16_t frame_crc(const uint8_t data[], uint8_t length, uint16_t data_id) {
    const uint32_t id = (data_id & 0xFFu) << 8 | data_id >> 8;
    uint32_t crc = 0xFFFFu;
    int i = 2;
    for (; i + 4 <= length; i += 4) {
        const uint8_t *byte = &data[i];
        crc = crc16(crc << 16 ^ ((uint32_t)byte[0] << 24 | (uint32_t)byte[1] << 16 | (uint32_t)byte[2] << 8 | byte[3]));
    }
    if (i + 2 == length) { /* as a rule: lengths are multiples of 4 */
        return (uint16_t)crc16(crc << 16 ^ (uint32_t)data[i] << 24 ^ (uint32_t)data[i + 1] << 16 ^ id);
    }
    for (; i < length; i++) {
        crc = crc << 8 ^ crc16((crc >> 8 & 0xFFu) ^ data[i]);
    }
    return (uint16_t)crc16((crc & 0xFFFFu) ^ id);
}

void e2e_protect(uint8_t data[], uint8_t length, uint16_t data_id, uint8_t counter) {
    data[2] = counter;
    uint16_t crc = frame_crc(data, length, data_id);
    data[0] = (uint8_t)(crc & 0xFFu);
    data[1] = (uint8_t)(crc >> 8);
}

e2e_status_t e2e_check(e2e_receiver_t *self, const uint8_t data[], uint8_t length, uint16_t data_id) {
    if (length < E2E_HEADER_BYTES) {
        return E2E_WRONG_CRC;
    }
    uint16_t received_crc = (uint16_t)(data[0] | (data[1] << 8));
    if (received_crc != frame_crc(data, length, data_id)) {
        return E2E_WRONG_CRC;
    }
    return follow(self, data[2], UINT8_MAX, E2E_MAX_DELTA);
}

/* ---- Profile 2 */

static uint8_t crc8(uint8_t crc, uint8_t byte) {
    crc ^= byte;
    for (int bit = 0; bit < 8; bit++) {
        crc = (uint8_t)(((unsigned)crc << 1) ^ ((crc & 0x80u) != 0u ? 0x2Fu : 0u));
    }
    return crc;
}

static uint8_t profile2_crc(const uint8_t data[], uint8_t length, uint16_t data_id) {
    uint8_t crc = 0xFFu;
    for (uint8_t i = 1; i < length; i++) {
        crc = crc8(crc, data[i]);
    }
    crc = crc8(crc, E2E_PROFILE2_DATA_ID(data_id, data[1] & COUNTER4_MASK));
    return crc ^ 0xFFu;
}

void e2e_profile2_protect(uint8_t data[], uint8_t length, uint16_t data_id, uint8_t counter) {
    data[1] = (uint8_t)((data[1] & ~COUNTER4_MASK) | (counter & COUNTER4_MASK));
    data[0] = profile2_crc(data, length, data_id);
}

e2e_status_t e2e_profile2_check(e2e_receiver_t *self, const uint8_t data[], uint8_t length, uint16_t data_id) {
    if (length < E2E_PROFILE2_HEADER_BYTES || data[0] != profile2_crc(data, length, data_id)) {
        return E2E_WRONG_CRC;
    }
    return follow(self, data[1] & COUNTER4_MASK, COUNTER4_MASK, E2E_PROFILE2_MAX_DELTA);
}
