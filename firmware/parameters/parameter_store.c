#include "parameter_store.h"

#include <string.h>

#include "../maths/float_bits.h"

#define MAGIC 0x504E4D43u /* "CMNP" */
#define LAYOUT_AT 4
#define VALUES_AT 8
#define CRC_BYTES 4
#define BYTES_FOR(count) ((size_t)VALUES_AT + 4u * (size_t)(count) + CRC_BYTES)

_Static_assert(sizeof(float) == sizeof(uint32_t), "float is not float32");

static uint32_t crc32(uint32_t crc, const uint8_t bytes[], size_t length) {
    crc = ~crc;
    for (size_t i = 0; i < length; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++) {
            crc = (crc >> 1) ^ (0xEDB88320u & (0u - (crc & 1u)));
        }
    }
    return ~crc;
}

_Static_assert(BYTES_FOR(PARAMETER_COUNT) == PARAMETER_STORE_BYTES, "two sizes of a record");

/* Of the first `count` parameters. */
static uint32_t layout(int count) {
    uint32_t crc = 0;
    for (int i = 0; i < count; i++) {
        const char *letter = parameter_table[i].name;
        do { /* with the 0 at the end */
            crc = crc32(crc, (const uint8_t *)letter, 1);
        } while (*letter++ != '\0');
    }
    return crc;
}

static void put(uint8_t bytes[4], uint32_t value) {
    for (int i = 0; i < 4; i++) {
        bytes[i] = (uint8_t)(value >> 8 * i);
    }
}

static uint32_t get(const uint8_t bytes[4]) {
    uint32_t value = 0;
    for (int i = 0; i < 4; i++) {
        value |= (uint32_t)bytes[i] << 8 * i;
    }
    return value;
}

void parameter_store_encode(const parameters_t *parameters, uint8_t record[PARAMETER_STORE_BYTES]) {
    put(record, MAGIC);
    put(&record[LAYOUT_AT], layout(PARAMETER_COUNT));
    for (int i = 0; i < PARAMETER_COUNT; i++) {
        put(&record[VALUES_AT + 4 * i], float_bits(parameters->value[i]));
    }
    put(&record[PARAMETER_STORE_BYTES - CRC_BYTES], crc32(0, record, PARAMETER_STORE_BYTES - CRC_BYTES));
}

/* How many parameters a record of this length has; 0: no record has it. */
static int count_of(size_t length) {
    int count = PARAMETER_COUNT;
    while (count > 0 && BYTES_FOR(count) != length) {
        count--;
    }
    return count;
}

bool parameter_store_decode(const uint8_t record[], size_t length, parameters_t *parameters) {
    const int count = count_of(length);
    if (count == 0 || get(record) != MAGIC || get(&record[LAYOUT_AT]) != layout(count) ||
        get(&record[length - CRC_BYTES]) != crc32(0, record, length - CRC_BYTES)) {
        return false;
    }
    parameters_t stored;
    parameters_set_defaults(&stored);
    for (uint8_t i = 0; i < count; i++) {
        const uint32_t bits = get(&record[VALUES_AT + 4 * i]);
        float value;
        memcpy(&value, &bits, sizeof value);
        if (parameters_set(&stored, i, value) != RESULT_ACCEPTED) {
            return false;
        }
    }
    *parameters = stored;
    return true;
}
