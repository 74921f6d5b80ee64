#include "rest_noise.h"

#include <math.h>

#include "../hand/tremor.h"
#include "../robot/position_jacobian.h"

#define FOLLOWING_PER_S 35.0
#define ESTIMATE_SHARE 0.25 /* share of a sample's noise that remains in the estimate of a hand at rest */
#define DAMPING_M2 1e-4 /* for singular start postures; elsewhere the squared singular values are 1e-3 to 1e-1 m^2 */

/* Returns the speed of the fastest joint per unit speed of the hand along each axis [rad/m]. This is the largest norm
 * of a row of the Jacobian's pseudo-inverse. */
static double largest_row_norm(const double position_rad[ROBOT_JOINTS]) {
    double hand_m[3], jacobian[ROBOT_JOINTS][3], row[3], largest = 0.0;
    position_jacobian(position_rad, hand_m, jacobian);
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        position_jacobian_solve((const double (*)[3])jacobian, NULL, DAMPING_M2, jacobian[i], row);
        largest = fmax(largest, sqrt(row[0] * row[0] + row[1] * row[1] + row[2] * row[2]));
    }
    return largest;
}

double rest_noise_radps(const scenario_t *scenario, const tracker_options_t *tracker, double motion_scale,
                        bool predicts) {
    double start_rad[ROBOT_JOINTS];
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        start_rad[i] = scenario->start_deg[i] * ROBOT_RAD_PER_DEG;
    }
    const double tremor_mps = tremor_speed_mps(1e-3 * scenario->person[scenario->tracked].tremor_mm);
    const double rate_per_s = predicts ? ESTIMATE_SHARE * FOLLOWING_PER_S : FOLLOWING_PER_S;
    const double hand_mps = motion_scale * hypot(tremor_mps, rate_per_s * tracker->noise_position_m);
    return hypot(largest_row_norm(start_rad) * hand_mps, rate_per_s * tracker->noise_rotation_rad);
}
