#include "tremor.h"

#include <math.h>

#include "../common/random.h"
#include "minimum_jerk.h"

#define TWO_PI 6.283185307179586
#define LOWEST_HZ 8.0
#define HIGHEST_HZ 12.0

void tremor_init(tremor_t *self, double rms_m, uint64_t seed, const char *name) {
    random_t random;
    random_init(&random, seed, name);
    /* each of the 3 * TREMOR_SINES sines adds amplitude^2 / 2 to the mean square */
    self->amplitude_m = rms_m * sqrt(2.0 / (3.0 * TREMOR_SINES));
    const double band_hz = (HIGHEST_HZ - LOWEST_HZ) / TREMOR_SINES; /* one sine per sub-band, to avoid slow beats */
    for (int axis = 0; axis < 3; axis++) {
        for (int n = 0; n < TREMOR_SINES; n++) {
            const double hz = LOWEST_HZ + band_hz * (n + random_uniform(&random));
            self->frequency_radps[axis][n] = TWO_PI * hz;
            self->phase_rad[axis][n] = TWO_PI * random_uniform(&random);
        }
    }
}

/* The frequencies are uniformly distributed over the band, so the mean of their squares is the second moment of a
 * uniform distribution. */
double tremor_speed_mps(double rms_m) {
    const double mean_square_Hz2 = (LOWEST_HZ * LOWEST_HZ + LOWEST_HZ * HIGHEST_HZ + HIGHEST_HZ * HIGHEST_HZ) / 3.0;
    return rms_m / sqrt(3.0) * TWO_PI * sqrt(mean_square_Hz2);
}

void tremor_sample(const tremor_t *self, double time_s, double displacement_m[3]) {
    const double amplitude_m = self->amplitude_m * minimum_jerk_share(time_s / TREMOR_RISE_S);
    for (int axis = 0; axis < 3; axis++) {
        double sum = 0.0;
        for (int n = 0; n < TREMOR_SINES && amplitude_m > 0.0; n++) {
            sum += sin(self->frequency_radps[axis][n] * time_s + self->phase_rad[axis][n]);
        }
        displacement_m[axis] = amplitude_m * sum;
    }
}
