/* Computes how fast the joints of a fault-free system move because of tremor and tracker noise while the person's hand
 * is at rest.
 *
 * The limit of the check comes_to_rest follows from this speed. The speed is computed, not measured, because the
 * controller must not influence its own limit and because a run may have no phase in which to measure the speed. In the
 * scenario's start posture, the end effector is assumed to follow the tremor at its full speed, and to follow the noise
 * of each sample at a rate of 35/s, the rate of the default controller. With prediction, the rate is a quarter of 35/s,
 * because the estimate filters out three quarters of the noise. (At a rate K, noise of s metres causes a speed of K
 * times s.) The speed of the fastest joint follows from the pseudo-inverse of the position Jacobian. Rotation noise is
 * assumed to move a joint by the same angle. */
#ifndef COMANIP_SIM_REST_NOISE_H
#define COMANIP_SIM_REST_NOISE_H

#include <stdbool.h>

#include "../nodes/tracker_node.h"
#include "../scenario/scenario.h"

/* Returns the RMS speed [rad/s] of the fastest joint; 0 without noise and tremor. motion_scale, predicts: current
 * values of the parameters. */
double rest_noise_radps(const scenario_t *scenario, const tracker_options_t *tracker, double motion_scale,
                        bool predicts);

#endif
