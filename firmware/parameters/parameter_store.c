/* Encodes and decodes the stored record of parameters: see parameter_store.h. */
#include "parameter_store.h"

#include <string.h>

#include "../maths/float_bits.h"

#define MAGIC_AT 0
#define COUNT_AT 4
#define VALUES_AT 5
#define VALUE_BYTES 5
#define CRC_BYTES 4

static const uint8_t magic[] = {'C', 'M', 'N', '2'};

_Static_assert(sizeof(float) == sizeof(uint32_t), "float is not float32");
_Static_assert(PARAMETER_COUNT <= PARAMETER_NUMBERS && PARAMETER_NUMBERS <= UINT8_MAX, "numbers are bytes");

static uint32_t crc32(const uint8_t bytes[], size_t length) {
    uint32_t crc = 0xFFFFFFFFu;
    for (size_t i = 0; i < length; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++) {
            crc = (crc >> 1) ^ (0xEDB88320u & (0u - (crc & 1u)));
        }
    }
    return ~crc;
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

static float get_float(const uint8_t bytes[4]) {
    const uint32_t bits = get(bytes);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static bool has_right_crc(const uint8_t record[], size_t length) {
    return length > CRC_BYTES && get(&record[length - CRC_BYTES]) == crc32(record, length - CRC_BYTES);
}

size_t parameter_store_encode(const parameters_t *parameters, uint8_t record[PARAMETER_STORE_BYTES]) {
    memcpy(&record[MAGIC_AT], magic, sizeof magic);
    uint8_t count = 0;
    for (uint8_t number = 0; number < PARAMETER_COUNT; number++) {
        if (parameters_has(number)) {
            uint8_t *entry = &record[VALUES_AT + VALUE_BYTES * count++];
            entry[0] = number;
            put(&entry[1], float_bits(parameters->value[number]));
        }
    }
    record[COUNT_AT] = count;
    const size_t end = VALUES_AT + (size_t)VALUE_BYTES * count;
    put(&record[end], crc32(record, end));
    return end + CRC_BYTES;
}

/* Stores a value; skips the value of an unknown parameter. Returns false if the value is out of range. */
static bool take(parameters_t *stored, uint8_t number, float value) {
    return !parameters_has(number) || parameters_set(stored, number, value) == RESULT_ACCEPTED;
}

static bool decode(const uint8_t record[], size_t length, parameters_t *stored) {
    if (length < VALUES_AT + CRC_BYTES || length != PARAMETER_STORE_RECORD_BYTES((size_t)record[COUNT_AT])) {
        return false;
    }
    for (uint8_t i = 0; i < record[COUNT_AT]; i++) {
        const uint8_t *entry = &record[VALUES_AT + VALUE_BYTES * i];
        if (!take(stored, entry[0], get_float(&entry[1]))) {
            return false;
        }
    }
    return true;
}

/* ---- the former record format, written by firmware with 38 to 43 parameters */

#define FORMER_NAMES_AT 4
#define FORMER_VALUES_AT 8
#define FORMER_COUNT_MIN 38
#define FORMER_COUNT_MAX 43

static const uint8_t former_magic[] = {'C', 'M', 'N', 'P'};

/* Entry i is the CRC-32 of the names of the first 38 + i parameters, each name with its terminating 0. */
static const uint32_t former_names[FORMER_COUNT_MAX - FORMER_COUNT_MIN + 1] = {
    0x51F3859Fu, 0x3BBF57B0u, 0xC93C10CFu, 0xCC105CC2u, 0x235A3D15u, 0x8F7CCC71u,
};

static bool decode_former(const uint8_t record[], size_t length, parameters_t *stored) {
    const size_t count = length < FORMER_VALUES_AT + CRC_BYTES ? 0u : (length - FORMER_VALUES_AT - CRC_BYTES) / 4u;
    if (count < FORMER_COUNT_MIN || count > FORMER_COUNT_MAX || length != FORMER_VALUES_AT + 4u * count + CRC_BYTES ||
        get(&record[FORMER_NAMES_AT]) != former_names[count - FORMER_COUNT_MIN]) {
        return false;
    }
    for (uint8_t number = 0; number < count; number++) {
        if (!take(stored, number, get_float(&record[FORMER_VALUES_AT + 4 * number]))) {
            return false;
        }
    }
    return true;
}

bool parameter_store_decode(const uint8_t record[], size_t length, parameters_t *parameters) {
    parameters_t stored;
    parameters_set_defaults(&stored);
    if (!has_right_crc(record, length)) {
        return false;
    }
    const bool is_former = memcmp(record, former_magic, sizeof former_magic) == 0;
    const bool is_known = is_former || memcmp(record, magic, sizeof magic) == 0;
    if (!is_known || !(is_former ? decode_former(record, length, &stored) : decode(record, length, &stored))) {
        return false;
    }
    *parameters = stored;
    return true;
}
