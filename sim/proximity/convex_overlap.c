/* Computes the penetration depth. libccd's own functions are not accurate enough: its expanding polytope does not stay
 * convex, and its portal refinement finds a separation, but not the shortest one. The depth is the smallest reach
 * (convex_reach_mm()) over all directions, so a search that misses the minimum returns too much, never too little. */
#include "convex_overlap.h"

#include <math.h>

#include "convex_support.h"

#define STEPS 150
#define FIRST_STEP_RAD 0.3
#define STEP_RATIO 0.93 /* ratio of successive steps; the last step is 6 urad */

static double length_of(const double v[3]) {
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static void normalise(double v[3]) {
    const double length = length_of(v);
    for (int i = 0; i < 3; i++) {
        v[i] /= length;
    }
}

/* Finds the smallest reach near a direction by subgradient descent on the unit sphere. The subgradient is the component
 * of the farthest point perpendicular to the direction. The steps become shorter and shorter, because steps of constant
 * length would not converge: the reach is not a smooth function of the direction. */
static double smallest_reach_near(const convex_operand_t *first, const convex_operand_t *second, double direction[3]) {
    double least_mm = HUGE_VAL, step_rad = FIRST_STEP_RAD;
    for (int k = 0; k < STEPS; k++) {
        double across[3];
        const double reach_mm = convex_reach_mm(first, second, direction, across);
        least_mm = fmin(least_mm, reach_mm);
        for (int i = 0; i < 3; i++) {
            across[i] -= reach_mm * direction[i];
        }
        const double slope = length_of(across);
        if (slope <= 0.0) {
            break;
        }
        for (int i = 0; i < 3; i++) {
            direction[i] -= step_rad * across[i] / slope;
        }
        normalise(direction);
        step_rad *= STEP_RATIO;
    }
    return least_mm;
}

double convex_overlap_m(const convex_shape_t *a, const convex_shape_t *b) {
    convex_operand_t first, second;
    convex_separation_t separation;
    convex_operands_init(&first, &second, a, b, &separation);
    double least_mm = HUGE_VAL;
    for (int start = 0; start < 27; start++) { /* starts from the directions of a cube's faces, edges and corners */
        const double cube[3] = {start % 3 - 1, start / 3 % 3 - 1, start / 9 - 1};
        if (length_of(cube) <= 0.0) {
            continue;
        }
        const convex_shape_t *shape[2] = {a, b};
        for (int i = 0; i < 2; i++) {
            double direction[3];
            rotation_apply(shape[i]->pose.rotation, cube, direction);
            normalise(direction);
            least_mm = fmin(least_mm, smallest_reach_near(&first, &second, direction));
        }
        if (least_mm <= 0.0) {
            return 0.0;
        }
    }
    return least_mm / MM_PER_M;
}
