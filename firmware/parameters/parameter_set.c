/* Checks the stability of the parameters: see parameter_set.h. */
#include "parameter_set.h"

_Static_assert(PARAMETER_NUMBERS <= 64, "parameter sets are 64-bit masks");

/* Largest k T (see parameter_set.h): pi / 2 minus a margin for the drives' lag and for braking by the joint limits,
 * measured by tests/rest. */
#define RATE_TIMES_DELAY_MAX 0.8f
#define COMMAND_DELAY_MIN_S 5e-3f /* used if the parameter is less, because no drive is assumed to act faster */
#define DELAY_TICKS 1.5f /* one tick for the age of a reading, and half a tick, on average, for holding a command */

static uint64_t bit(int parameter) {
    return UINT64_C(1) << parameter;
}

/* The paper's control law is never refused, regardless of its gains. */
static bool is_the_papers_law(const parameters_t *parameters) {
    bool found = parameters->value[PARAMETER_ERROR_FRAME] == (float)ERROR_FRAME_TORSO;
    for (int i = 0; i < 8; i++) {
        found = found && parameters->value[PARAMETER_WEIGHT + i] == 1.0f;
    }
    return found;
}

static uint64_t too_fast_gains(const parameters_t *parameters, float gain_max_per_s) {
    if (parameters_predict(parameters)) {
        const bool is_too_fast = parameters->value[PARAMETER_FOLLOWING_GAIN_PER_S] > gain_max_per_s;
        return is_too_fast ? bit(PARAMETER_FOLLOWING_GAIN_PER_S) : 0u;
    }
    uint64_t involved = 0;
    for (int i = 0; i < 8; i++) {
        const bool counts = parameters->value[PARAMETER_WEIGHT + i] > 0.0f;
        if (counts && parameters->value[PARAMETER_GAIN_PER_S + i] > gain_max_per_s) {
            involved |= bit(PARAMETER_GAIN_PER_S + i);
        }
    }
    return involved;
}

/* Returns the parameters that make the loop faster than its delays allow. */
static uint64_t too_fast(const parameters_t *parameters, float tick_s) {
    const float reported_s = parameters->value[PARAMETER_COMMAND_DELAY_S];
    const float delay_s = (reported_s > COMMAND_DELAY_MIN_S ? reported_s : COMMAND_DELAY_MIN_S) + DELAY_TICKS * tick_s;
    const uint64_t involved = too_fast_gains(parameters, RATE_TIMES_DELAY_MAX / delay_s);
    return involved != 0u && reported_s > COMMAND_DELAY_MIN_S ? involved | bit(PARAMETER_COMMAND_DELAY_S) : involved;
}

parameter_set_t parameter_set_check(const parameters_t *parameters, float tick_s) {
    const uint64_t involved = too_fast(parameters, tick_s);
    if (parameters_predict(parameters)) {
        return (parameter_set_t){involved == 0u ? PARAMETER_SET_RESTS : PARAMETER_SET_UNSTABLE, involved};
    }
    if (involved == 0u) {
        /* Stable near the target, but the arm may oscillate when it is stretched out towards a target out of reach. */
        return (parameter_set_t){PARAMETER_SET_MAY_SWING, bit(PARAMETER_PREDICTION)};
    }
    return (parameter_set_t){is_the_papers_law(parameters) ? PARAMETER_SET_MAY_SWING : PARAMETER_SET_UNSTABLE,
                             involved};
}
