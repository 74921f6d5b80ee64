/* Sine and cosine of our own: the same bits on every target, no libm.
 *
 * Two-step Cody-Waite reduction to [-pi/4, pi/4], then minimax polynomials of degree 7 and 8. Absolute error below
 * 1.2e-7 for |angle| <= TRIGONOMETRY_MAX_RAD (tested against double precision). Beyond, or not finite: both are NaN. */
#ifndef COMANIP_TRIGONOMETRY_H
#define COMANIP_TRIGONOMETRY_H

#define TRIGONOMETRY_MAX_RAD 64.0f

void sine_cosine(float angle_rad, float *sine, float *cosine);

#endif
