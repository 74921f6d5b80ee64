/* Questions about a float32 that its bits answer: without a floating-point unit, a comparison is a call. */
#ifndef COMANIP_FLOAT_BITS_H
#define COMANIP_FLOAT_BITS_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

static inline uint32_t float_bits(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

/* Of the magnitude: ordered as the magnitudes are, infinity above all numbers, and NaN above it. */
static inline uint32_t float_magnitude_bits(float x) {
    return float_bits(x) & 0x7FFFFFFFu;
}

static inline bool float_is_finite(float x) {
    return float_magnitude_bits(x) < 0x7F800000u;
}

static inline bool float_is_negative(float x) {
    return float_bits(x) >> 31 != 0u;
}

/* The nearest whole number, away from 0 where two are; of up to 2^23. */
static inline int32_t float_nearest(float x) {
    const uint32_t half_bits = (float_bits(x) & 0x80000000u) | 0x3F000000u;
    float half;
    memcpy(&half, &half_bits, sizeof half);
    return (int32_t)(x + half);
}

#endif
