/* Models the 8 to 12 Hz component of a hand's physiological tremor (R. J. Elble, J. E. Randall, "Mechanistic components
 * of normal hand tremor", Electroencephalography and Clinical Neurophysiology 44, 1978) as a sum of sines, so that
 * velocity and acceleration are smooth. tests/test_tremor.py compares the amplitude with that of recorded hands. */
#ifndef COMANIP_SIM_TREMOR_H
#define COMANIP_SIM_TREMOR_H

#include <stdint.h>

#define TREMOR_SINES 6    /* number of sines per axis */
#define TREMOR_RISE_S 0.5 /* duration of the rise from zero; the hand starts at rest in its start pose */

typedef struct {
    double amplitude_m; /* amplitude of each sine */
    double frequency_radps[3][TREMOR_SINES];
    double phase_rad[3][TREMOR_SINES];
} tremor_t;

/* rms_m: RMS displacement, all axes combined. The same seed and name give the same tremor. */
void tremor_init(tremor_t *self, double rms_m, uint64_t seed, const char *name);

/* Returns the RMS speed [m/s] along one axis that is expected for this RMS displacement. The random frequencies of a
 * tremor cause its actual RMS speed to differ slightly. */
double tremor_speed_mps(double rms_m);

void tremor_sample(const tremor_t *self, double time_s, double displacement_m[3]);

#endif
