/* An inline version of sine_cosine(), and its parts. For angles within +-pi/2, which include most half angles of
 * joints, it makes no function call. */
#ifndef COMANIP_TRIGONOMETRY_INLINE_H
#define COMANIP_TRIGONOMETRY_INLINE_H

#include <stdbool.h>

#include "float_bits.h"
#include "trigonometry.h"

/* Minimax polynomials on [-pi/2, pi/2]. The sine is x + x^3 (SINE_3 + ...), and the cosine is 1 - x^2 / 2 + x^4
 * (COSINE_4 + ...). */
#define SINE_3 -0.166666567f
#define SINE_5 8.33301712e-3f
#define SINE_7 -1.98066016e-4f
#define SINE_9 2.60002457e-6f
#define COSINE_4 4.16666567e-2f
#define COSINE_6 -1.38885691e-3f
#define COSINE_8 2.47692915e-5f
#define COSINE_10 -2.61935497e-7f

static inline bool sine_cosine_is_small(float angle_rad) {
    return float_magnitude_bits(angle_rad) <= float_magnitude_bits(1.57079637f);
}

static inline sine_cosine_t sine_cosine_small(float angle_rad) {
    const float z = angle_rad * angle_rad;
    const float sine = ((SINE_9 * z + SINE_7) * z + SINE_5) * z + SINE_3;
    const float cosine = ((COSINE_10 * z + COSINE_8) * z + COSINE_6) * z + COSINE_4;
    return (sine_cosine_t){sine * (z * angle_rad) + angle_rad, cosine * (z * z) + (1.0f - 0.5f * z)};
}

/* Computes sine and cosine for angles beyond +-pi/2. */
sine_cosine_t sine_cosine_reduced(float angle_rad);

static inline sine_cosine_t sine_cosine_inline(float angle_rad) {
    return sine_cosine_is_small(angle_rad) ? sine_cosine_small(angle_rad) : sine_cosine_reduced(angle_rad);
}

#endif
