/* Determines whether the isotropic form applies, and prepares its constants: see differential_ik.h. */
#include "differential_ik.h"

/* The isotropic form has no step of iterative refinement, so the error of its solution is the rounding error of J^T W J
 * divided by the damping. The rotation's weight contributes most to this error, because axes are unit vectors, whereas
 * levers are usually shorter than 1 m. Outside the following bounds, differential_ik_general() is used, which refines
 * its solution. The bounds were found by measurement (tests/test_differential_ik.py). */
#define DAMPING_MIN 1e-5f                 /* relative to the largest weight */
#define ROTATION_WEIGHT_MAX 1.0f          /* the rotation's weight must be at most this, */
#define ROTATION_TO_TRANSLATION_MAX 0.25f /* or at most this multiple of the translation's weight */
#define TRACE_DAMPING_MIN 1e-6f           /* relative to the trace of J^T W J; checked in each tick */

static bool is_isotropic(const float diagonal[8]) {
    for (int i = 1; i < 4; i++) {
        if (diagonal[i] != diagonal[0] || diagonal[4 + i] != diagonal[4]) {
            return false;
        }
    }
    return true;
}

static bool needs_no_refinement(float rotation, float translation, float damping) {
    const float largest = rotation > translation ? rotation : translation;
    return damping > 0.0f && translation > 0.0f && damping >= DAMPING_MIN * largest &&
           (rotation <= ROTATION_WEIGHT_MAX || rotation <= ROTATION_TO_TRANSLATION_MAX * translation);
}

void differential_ik_prepare(differential_ik_config_t *config) {
    const float rotation = config->weight[0], translation = config->weight[4];
    config->isotropic = (differential_ik_isotropic_t){
        .applies = is_isotropic(config->gain_per_s) && is_isotropic(config->weight) &&
                   needs_no_refinement(rotation, translation, config->damping),
    };
    if (config->isotropic.applies) {
        const float ratio = rotation / translation;
        const float damping = 4.0f * config->damping / translation;
        config->isotropic.weight_rotation = ratio;
        config->isotropic.pull_rotation = 2.0f * ratio * config->gain_per_s[0];
        config->isotropic.pull_translation = 2.0f * config->gain_per_s[4];
        config->isotropic.diagonal = ratio + damping;
        config->isotropic.trace_max = damping / TRACE_DAMPING_MIN - (float)ARM_MAX_JOINTS * ratio;
    }
}
