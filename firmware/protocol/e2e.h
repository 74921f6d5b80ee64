/* End-to-end protection. Source: AUTOSAR FO R22-11, PRS_E2EProtocol.
 *
 * Profile 5 (6.6), on CAN FD: CRC-16 (0x1021, initial 0xFFFF) little-endian at byte 0, 8-bit counter at byte 2, and an
 * implicit 16-bit Data ID, low byte first, after the data.
 *
 * Profile 2 (6.4), on classic CAN: CRC-8 (0x2F, initial and final XOR 0xFF) at byte 0, 4-bit counter in the low half of
 * byte 1, and after the data an implicit Data ID, which the counter selects from 16 (see E2E_PROFILE2_DATA_ID).
 * This profile is weaker: one in 256 corrupted frames has a correct CRC, and a frame delayed by 16 messages looks new,
 * because the counter has wrapped. */
#ifndef COMANIP_E2E_H
#define COMANIP_E2E_H

#include <stdbool.h>
#include <stdint.h>

#define E2E_HEADER_BYTES 3
#define E2E_MAX_DELTA 10 /* largest accepted step of the counter; a frame with a larger one is refused */

#define E2E_PROFILE2_HEADER_BYTES 2
#define E2E_PROFILE2_COUNTERS 16
#define E2E_PROFILE2_MAX_DELTA 5
#define E2E_PROFILE2_DATA_ID(data_id, counter) ((uint8_t)((data_id) + 16u * (counter)))

typedef enum {
    E2E_OK = 0,
    E2E_SOME_LOST = 1,
    E2E_WRONG_CRC = -1,
    E2E_REPEATED = -2,
    E2E_WRONG_SEQUENCE = -3,
} e2e_status_t;

typedef struct {
    bool started; /* false: the next frame may have any counter */
    uint8_t counter;
} e2e_receiver_t;

/* Writes the header to data[0..2]. length: length of the whole frame, at least E2E_HEADER_BYTES. */
void e2e_protect(uint8_t data[], uint8_t length, uint16_t data_id, uint8_t counter);

/* Checks a received frame and updates the expected counter. The data must not be used if the status is negative. */
e2e_status_t e2e_check(e2e_receiver_t *self, const uint8_t data[], uint8_t length, uint16_t data_id);

/* The same functions for Profile 2. length: at most 8; the high half of byte 1 is payload. counter: modulo 16. */
void e2e_profile2_protect(uint8_t data[], uint8_t length, uint16_t data_id, uint8_t counter);
e2e_status_t e2e_profile2_check(e2e_receiver_t *self, const uint8_t data[], uint8_t length, uint16_t data_id);

#endif
