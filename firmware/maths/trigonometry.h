/* Sine and cosine of our own: the same bits on every target, no libm. Absolute error below 1.2e-7 for |angle| <=
 * TRIGONOMETRY_MAX_RAD (tested against double precision). Beyond, or not finite: both are NaN. */
#ifndef COMANIP_TRIGONOMETRY_H
#define COMANIP_TRIGONOMETRY_H

#define TRIGONOMETRY_MAX_RAD 64.0f

typedef struct {
    float sine, cosine;
} sine_cosine_t;

sine_cosine_t sine_cosine(float angle_rad);

#endif
