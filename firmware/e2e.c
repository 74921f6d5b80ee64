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

static uint16_t crc16(uint16_t crc, uint8_t byte) {
    /* CRC-16/CCITT (0x1021) of one byte without a table: the polynomial's taps folded by hand */
    uint8_t x = (uint8_t)((crc >> 8) ^ byte);
    x ^= (uint8_t)(x >> 4);
    return (uint16_t)((crc << 8) ^ (uint16_t)(x << 12) ^ (uint16_t)(x << 5) ^ x);
}

static uint16_t frame_crc(const uint8_t data[], uint8_t length, uint16_t data_id) {
    uint16_t crc = 0xFFFFu;
    for (uint8_t i = 2; i < length; i++) {
        crc = crc16(crc, data[i]);
    }
    crc = crc16(crc, (uint8_t)(data_id & 0xFFu));
    return crc16(crc, (uint8_t)(data_id >> 8));
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
