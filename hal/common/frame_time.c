/* Computes a frame's duration from its bits. A table advances the bit stuffing by eight bits at a time, because
 * handling the bits of 64 bytes one by one would cost more than the rest of the bus model. */
#include "frame_time.h"

#include <stdbool.h>

#define NOMINAL_BIT_NS 1000
#define DATA_BIT_NS 200

/* Bits at the nominal rate: SOF, id 11, RRS, IDE, FDF, res, BRS; ACK, ACK delimiter, EOF 7, intermission 3. */
#define NOMINAL_BITS (17 + 12)
/* Bits at the data rate outside the data field and the CRC field: ESI, DLC 4; CRC delimiter. */
#define DATA_PHASE_BITS (5 + 1)
/* Stuff count 4, CRC, and a fixed stuff bit before the first and after every fourth of these bits. */
#define CRC17_FIELD_BITS (4 + 17 + 6)
#define CRC21_FIELD_BITS (4 + 21 + 7)
#define CRC17_MAX_BYTES 16

/* Classic CAN: SOF, id 11, RTR, IDE, FDF, DLC 4, CRC 15; CRC delimiter, ACK, ACK delimiter, EOF 7, intermission 3. */
#define CLASSIC_BITS (19 + 15 + 13)
#define CLASSIC_MAX_BYTES 8
#define CRC15_POLYNOMIAL 0x4599U
#define CRC15_MASK 0x7FFFU

#define ID_MAX 0x7FFU
#define STUFF_RUN 5U

/* State of the bit stuffing: the last bit sent, and the number of times it has been sent in a row, 1..STUFF_RUN. A
 * stuff bit is counted when the next bit is sent. A run that ends with the data therefore causes no stuff bit, as in
 * the standard, where the fixed stuff bit is sent instead. */
#define STATE(bit, run) (((bit) << 3) | (run))
#define STATES 16

typedef struct {
    uint8_t state;
    uint8_t stuff_bits;
} stuffing_t;

static stuffing_t stuffing_step(stuffing_t before, unsigned int bit) {
    unsigned int last = before.state >> 3;
    unsigned int run = before.state & 7U;
    unsigned int stuff_bits = before.stuff_bits;
    if (run == STUFF_RUN) {
        last ^= 1U;
        run = 1;
        stuff_bits++;
    }
    run = bit == last ? run + 1U : 1U;
    return (stuffing_t){.state = (uint8_t)STATE(bit, run), .stuff_bits = (uint8_t)stuff_bits};
}

/* Returns the table: table[state][octet] is the state after the octet's bits, most significant first, and the number of
 * stuff bits inserted among them. */
static const stuffing_t (*stuffing_table(void))[256] {
    static stuffing_t table[STATES][256];
    static bool built = false;
    if (!built) {
        for (unsigned int bit = 0; bit < 2; bit++) {
            for (unsigned int run = 1; run <= STUFF_RUN; run++) {
                for (unsigned int octet = 0; octet < 256; octet++) {
                    stuffing_t stuffing = {.state = (uint8_t)STATE(bit, run), .stuff_bits = 0};
                    for (int shift = 7; shift >= 0; shift--) {
                        stuffing = stuffing_step(stuffing, (octet >> shift) & 1U);
                    }
                    table[STATE(bit, run)][octet] = stuffing;
                }
            }
        }
        built = true;
    }
    return (const stuffing_t(*)[256])table;
}

static int data_length_code(uint8_t length) {
    static const uint8_t long_length[] = {12, 16, 20, 24, 32, 48, 64};
    if (length <= 8) {
        return length;
    }
    for (int i = 0; i < (int)sizeof long_length; i++) {
        if (length == long_length[i]) {
            return 9 + i;
        }
    }
    return -1;
}

static int64_t fd_ns(const can_frame_t *frame) {
    const int dlc = data_length_code(frame->length);
    if (dlc < 0 || frame->id > ID_MAX) {
        return -1;
    }
    const stuffing_t(*table)[256] = stuffing_table();

    const unsigned int id = frame->id;

    /* The bits 01, which represent bus idle and cause no stuffing, then SOF = 0, id, RRS = 0, IDE = 0 | FDF = 1,
     * res = 0, BRS = 1, ESI = 0, DLC. The bits FDF, res, BRS and ESI alternate. A run of five equal bits therefore ends
     * at IDE or earlier, or at the last bit of the DLC. In the latter case the stuff bit is counted with the data. All
     * stuff bits within this header are thus sent at the nominal bit rate. */
    const uint8_t header[3] = {
        (uint8_t)(0x40U | (id >> 6)),
        (uint8_t)((id << 2) & 0xFFU),
        (uint8_t)(0xA0U | (unsigned int)dlc),
    };
    unsigned int state = STATE(1U, 1U);
    unsigned int nominal_stuff_bits = 0;
    for (int i = 0; i < 3; i++) {
        const stuffing_t *stuffing = &table[state][header[i]];
        nominal_stuff_bits += stuffing->stuff_bits;
        state = stuffing->state;
    }

    unsigned int data_stuff_bits = 0;
    for (int i = 0; i < frame->length; i++) {
        const stuffing_t *stuffing = &table[state][frame->data[i]];
        data_stuff_bits += stuffing->stuff_bits;
        state = stuffing->state;
    }

    const unsigned int crc_field_bits = frame->length <= CRC17_MAX_BYTES ? CRC17_FIELD_BITS : CRC21_FIELD_BITS;
    const unsigned int data_bits = DATA_PHASE_BITS + 8U * frame->length + data_stuff_bits + crc_field_bits;
    return (int64_t)(NOMINAL_BITS + nominal_stuff_bits) * NOMINAL_BIT_NS + (int64_t)data_bits * DATA_BIT_NS;
}

static unsigned int crc15(unsigned int crc, unsigned int octet) {
    for (int shift = 7; shift >= 0; shift--) {
        const unsigned int is_one = ((crc >> 14) ^ (octet >> shift)) & 1U;
        crc = ((crc << 1) & CRC15_MASK) ^ (is_one * CRC15_POLYNOMIAL);
    }
    return crc;
}

static unsigned int add_stuff_bits(unsigned int *state, unsigned int octet) {
    const stuffing_t *stuffing = &stuffing_table()[*state][octet];
    *state = stuffing->state;
    return stuffing->stuff_bits;
}

static int64_t classic_ns(const can_frame_t *frame) {
    if (frame->length > CLASSIC_MAX_BYTES || frame->id > ID_MAX) {
        return -1;
    }
    /* SOF = 0, id, RTR = IDE = FDF = 0, DLC. The five preceding bits represent bus idle. In the CRC they are zeros,
     * which leave its initial 0 unchanged; in the stuffing they are 10101, which causes no stuff bit. */
    const unsigned int header = ((unsigned int)frame->id << 7) | frame->length;
    const unsigned int idle = 0xA80000U;
    unsigned int state = STATE(1U, 1U), stuff_bits = 0, crc = 0;
    for (int shift = 16; shift >= 0; shift -= 8) {
        crc = crc15(crc, (header >> shift) & 0xFFU);
        stuff_bits += add_stuff_bits(&state, ((header | idle) >> shift) & 0xFFU);
    }
    for (int i = 0; i < frame->length; i++) {
        crc = crc15(crc, frame->data[i]);
        stuff_bits += add_stuff_bits(&state, frame->data[i]);
    }
    const unsigned int crc_and_delimiter =
        (crc << 1) | 1U; /* a run that ends with the CRC is stuffed before the delimiter */
    stuff_bits += add_stuff_bits(&state, crc_and_delimiter >> 8);
    stuff_bits += add_stuff_bits(&state, crc_and_delimiter & 0xFFU);
    return (int64_t)(CLASSIC_BITS + 8U * frame->length + stuff_bits) * NOMINAL_BIT_NS;
}

int64_t frame_time_ns(const can_frame_t *frame) {
    return frame->fd ? fd_ns(frame) : classic_ns(frame);
}
