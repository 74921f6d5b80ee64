/* Float predicates that work on bit patterns. Without a floating-point unit, a float comparison is a function call,
 * whereas these predicates are a few integer instructions. */
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

/* Returns the bits of |x|. As integers, these bits are ordered like the magnitudes, with infinity above all numbers and
 * NaN above infinity. */
static inline uint32_t float_magnitude_bits(float x) {
    return float_bits(x) & 0x7FFFFFFFu;
}

static inline bool float_is_finite(float x) {
    return float_magnitude_bits(x) < 0x7F800000u;
}

static inline bool float_is_negative(float x) {
    return float_bits(x) >> 31 != 0u;
}

/* Returns whether x < limit, provided that x and limit are not both negative. As integers, the bits of non-negative
 * floats are ordered like the floats, and those of negative floats are below them. -0 counts as below +0. The result
 * for a NaN depends on its sign, which differs between processors, so callers must not rely on it. */
static inline bool float_is_below(float x, float limit) {
    return (int32_t)float_bits(x) < (int32_t)float_bits(limit);
}

/* Returns the smaller of two values, neither of which may be negative. */
static inline float float_smaller(float a, float b) {
    return float_is_below(a, b) ? a : b;
}

/* Rounds to the nearest integer, with ties away from 0, by adding 0.5 with the sign of x and truncating. A magnitude
 * just below a tie may be rounded up, because the sum itself is rounded. |x| must be below 2^31, and x must not be
 * NaN. */
static inline int32_t float_nearest(float x) {
    const uint32_t half_bits = (float_bits(x) & 0x80000000u) | 0x3F000000u;
    float half;
    memcpy(&half, &half_bits, sizeof half);
    return (int32_t)(x + half);
}

#endif
