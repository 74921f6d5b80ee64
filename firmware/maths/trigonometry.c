/* Sine and cosine with range reduction: see trigonometry.h. */
#include "trigonometry.h"

#include <stdint.h>

#include "trigonometry_inline.h"

/* Cody-Waite reduction to [-pi/4, pi/4]. */
sine_cosine_t sine_cosine_reduced(float angle_rad) {
    if (!(angle_rad >= -TRIGONOMETRY_MAX_RAD && angle_rad <= TRIGONOMETRY_MAX_RAD)) {
        return (sine_cosine_t){__builtin_nanf(""), __builtin_nanf("")};
    }
    float turns = angle_rad * 0.63661977236758134f; /* quarter turns, 2/pi */
    int32_t quadrant = (int32_t)(turns + (turns < 0.0f ? -0.5f : 0.5f));
    float k = (float)quadrant;
    /* pi/2 in three parts; k times each of the first two is exact for |k| <= 41, which covers the accepted range */
    float x = ((angle_rad - k * 1.5703125f) - k * 4.8375129699707031e-4f) - k * 7.5497899548918861e-8f;
    const sine_cosine_t near = sine_cosine_small(x);
    const float s = near.sine, c = near.cosine;
    switch ((uint32_t)quadrant & 3u) {
    case 0u: return (sine_cosine_t){s, c};
    case 1u: return (sine_cosine_t){c, -s};
    case 2u: return (sine_cosine_t){-s, -c};
    default: return (sine_cosine_t){-c, s};
    }
}

sine_cosine_t sine_cosine(float angle_rad) {
    return sine_cosine_inline(angle_rad);
}
