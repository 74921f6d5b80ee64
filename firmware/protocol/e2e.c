/* End-to-end protection, Profiles 5 and 2: see e2e.h. */
#include "e2e.h"

#define COUNTER4_MASK 0x0Fu

/* Checks the counter of a frame that has a correct CRC. */
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

/* CRC-16/CCITT computed word by word, without a table. The polynomial is P = x^16 + x^12 + x^5 + 1. Modulo 2, a square
 * has no mixed terms, so P^2 = x^32 + x^24 + x^10 + 1. The remainder modulo P^2 is a 32-bit word; at the end, crc_end()
 * computes the remainder of that word modulo P.
 *
 * Let y be the word that is shifted out at the top. Its quotient by P^2 is y + D y + D^2 y + ..., where D y is the part
 * of y (x^24 + x^10 + 1) that overflows 32 bits. This sum equals (1 + D) (1 + D^2) (1 + D^4) ... y. */
static uint32_t crc_word(uint32_t crc, uint32_t word) {
    uint32_t q = crc ^ crc >> 8 ^ crc >> 22;
    q ^= q >> 16;
    return word ^ q ^ q << 10 ^ q << 24;
}

/* Returns y x^16 modulo P. */
static uint32_t crc_end(uint32_t y) {
    uint32_t q = y ^ y >> 4 ^ y >> 11 ^ y >> 16;
    q ^= q >> 8 ^ q >> 22;
    q ^= q >> 16;
    return (q ^ q << 5 ^ q << 12) & 0xFFFFu;
}

/* x^-16 0xFFFF modulo P; used as the first word, it makes the CRC start from 0xFFFF. */
#define CRC_START 0x84CFu

static uint16_t frame_crc(const uint8_t data[], uint8_t length, uint16_t data_id) {
    const uint32_t id = (data_id & 0xFFu) << 8 | data_id >> 8;
    uint32_t words = CRC_START;
    int i = 2;
    for (; i + 4 <= length; i += 4) {
        const uint8_t *byte = &data[i];
        words = crc_word(words, (uint32_t)byte[0] << 24 | (uint32_t)byte[1] << 16 | (uint32_t)byte[2] << 8 | byte[3]);
    }
    if (i + 2 == length) { /* the usual case, because lengths are multiples of 4 */
        return (uint16_t)crc_end(crc_word(words, (uint32_t)data[i] << 24 | (uint32_t)data[i + 1] << 16 | id));
    }
    uint32_t crc = crc_end(words);
    for (; i < length; i++) {
        crc = (crc << 8 & 0xFFFFu) ^ crc_end(crc >> 8 ^ data[i]);
    }
    return (uint16_t)crc_end(crc ^ id);
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
