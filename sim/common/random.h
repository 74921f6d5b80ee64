/* Seeded random numbers. Each part of the simulator draws from its own stream, so adding a part does not change the
 * numbers that the others get. */
#ifndef COMANIP_SIM_RANDOM_H
#define COMANIP_SIM_RANDOM_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    uint64_t word[4]; /* SFC64: three words of state and a counter */
    bool has_spare;
    double spare; /* second number of the last Gaussian pair */
} random_t;

/* Starts a stream. The same seed and stream name always produce the same numbers. */
void random_init(random_t *self, uint64_t seed, const char *stream);

uint64_t random_bits(random_t *self);

/* Returns a number uniformly distributed over [0, 1), with 53 random bits. */
double random_uniform(random_t *self);

/* Returns a normally distributed number with mean 0 and standard deviation 1. */
double random_gaussian(random_t *self);

#endif
