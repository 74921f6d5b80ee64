/* Sine and cosine, computed without libm, with the same bits on every target. The absolute error is below 1.2e-7 for
 * |angle| <= TRIGONOMETRY_MAX_RAD (tested against double precision). For larger or non-finite angles, both results are
 * NaN. */
#ifndef COMANIP_TRIGONOMETRY_H
#define COMANIP_TRIGONOMETRY_H

#define TRIGONOMETRY_MAX_RAD 64.0f

typedef struct {
    float sine, cosine;
} sine_cosine_t;

sine_cosine_t sine_cosine(float angle_rad);

#endif
