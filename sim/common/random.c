/* The SFC64 generator (C. Doty-Humphrey, PractRand) and the Box-Muller transform. */
#include "random.h"

#include <math.h>

#define WARM_UP_ROUNDS 12 /* the number used by PractRand; the rounds mix the words of the seed */

void random_init(random_t *self, uint64_t seed, const char *stream) {
    uint64_t name_hash = 0xCBF29CE484222325U; /* FNV-1a */
    for (const char *character = stream; *character != '\0'; character++) {
        name_hash = (name_hash ^ (uint8_t)*character) * 0x100000001B3U;
    }
    *self = (random_t){.word = {seed, name_hash, 0, 1}};
    for (int i = 0; i < WARM_UP_ROUNDS; i++) {
        (void)random_bits(self);
    }
}

uint64_t random_bits(random_t *self) {
    uint64_t *w = self->word;
    const uint64_t result = w[0] + w[1] + w[3];
    w[3]++;
    w[0] = w[1] ^ (w[1] >> 11);
    w[1] = w[2] + (w[2] << 3);
    w[2] = ((w[2] << 24) | (w[2] >> 40)) + result;
    return result;
}

double random_uniform(random_t *self) {
    return (double)(random_bits(self) >> 11) * 0x1p-53;
}

double random_gaussian(random_t *self) {
    if (self->has_spare) {
        self->has_spare = false;
        return self->spare;
    }
    const double two_pi = 6.283185307179586;
    const double radius = sqrt(-2.0 * log(1.0 - random_uniform(self))); /* 1 - random_uniform() is never 0 */
    const double angle = two_pi * random_uniform(self);
    self->has_spare = true;
    self->spare = radius * sin(angle);
    return radius * cos(angle);
}
