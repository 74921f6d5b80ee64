/* What the bits of a float32 answer, and serve for: without a floating-point unit, a comparison is a call. */
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

/* x < limit, unless both are negative: as whole numbers, the bits of negative floats are below those of the others,
 * which are ordered as they are. -0 is below +0. A NaN answers by its sign, which differs between processors: none may
 * get here where the answer counts. */
static inline bool float_is_below(float x, float limit) {
    return (int32_t)float_bits(x) < (int32_t)float_bits(limit);
}

/* Neither may be negative. */
static inline float float_smaller(float a, float b) {
    return float_is_below(a, b) ? a : b;
}

/* The whole number that is left of x and half more, away from 0: the nearest one, but for x itself being rounded up
 * when half is added. |x| below 2^31; NaN is not one. */
static inline int32_t float_nearest(float x) {
    const uint32_t half_bits = (float_bits(x) & 0x80000000u) | 0x3F000000u;
    float half;
    memcpy(&half, &half_bits, sizeof half);
    return (int32_t)(x + half);
}

#endif
