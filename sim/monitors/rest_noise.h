/* How fast the joints move, without any fault, while a trembling hand rests and a noisy tracker looks at it.
 *
 * Computed, not measured: a law must not choose what it is judged by, and a run need not have a phase to measure it in.
 * In the scenario's start posture, which the arm can take, the robot's hand goes along with all of the tremor's speed,
 * and moves by each sample's noise at 35/s, the default law's rate, or, where the motion is predicted, by a quarter of
 * it, which its estimate leaves (following at a rate of K turns noise of s metres into a speed of K s): through the
 * pseudo-inverse of the position's Jacobian this gives the joint that moves most. The rotation's noise turns a joint as
 * far as itself. */
#ifndef COMANIP_SIM_REST_NOISE_H
#define COMANIP_SIM_REST_NOISE_H

#include <stdbool.h>

#include "../nodes/tracker_node.h"
#include "../scenario/scenario.h"

/* RMS [rad/s] of the joint that moves most; 0 without noise and tremor. motion_scale, predicts: the parameters in
 * force. */
double rest_noise_radps(const scenario_t *scenario, const tracker_options_t *tracker, double motion_scale,
                        bool predicts);

#endif
