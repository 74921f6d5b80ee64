#include "convex_distance.h"

#include <math.h>
#include <stdbool.h>

#include "convex_support.h"

#define BRACKET_M (1.6 * CONVEX_DISTANCE_ERROR_M) /* the answer is its middle: rounding has a fifth of the bound */

typedef struct {
    ccd_t ccd;
    convex_operand_t first, second;
    convex_separation_t separation;
} search_t;

/* Between their bounding spheres; negative if these overlap. */
static double sphere_distance_m(const convex_shape_t *a, const convex_shape_t *b) {
    const double *p = a->pose.position_m, *q = b->pose.position_m;
    const double d[3] = {q[0] - p[0], q[1] - p[1], q[2] - p[2]};
    return sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) - a->bounding_radius_m - b->bounding_radius_m;
}

static void search_init(search_t *self, const convex_shape_t *a, const convex_shape_t *b) {
    convex_support_configure(&self->ccd);
    convex_operands_init(&self->first, &self->second, a, b, &self->separation);
}

static double separation_m(const search_t *self) {
    return self->separation.distance_mm / MM_PER_M;
}

/* Do they meet if one is grown by the margin? Not if some direction separates them: where GJK gives up without having
 * found one, it is on the surface, within its rounding. */
static bool meets(search_t *self, double margin_m) {
    self->first.margin_mm = MM_PER_M * margin_m;
    return ccdGJKIntersect(&self->first, &self->second, &self->ccd) != 0 || separation_m(self) < margin_m;
}

double convex_distance_m(const convex_shape_t *a, const convex_shape_t *b, double ceiling_m, double guess_m) {
    double lower_m = fmax(sphere_distance_m(a, b), 0.0), upper_m = ceiling_m;
    if (lower_m >= ceiling_m) {
        return ceiling_m;
    }
    search_t search;
    search_init(&search, a, b);
    double margin_m = guess_m >= 0.0 ? guess_m + 0.5 * BRACKET_M : ceiling_m;
    bool halves = false;
    while (upper_m - lower_m > BRACKET_M) {
        if (!(margin_m > lower_m && margin_m < upper_m)) {
            margin_m = 0.5 * (lower_m + upper_m);
        }
        if (meets(&search, margin_m)) {
            upper_m = margin_m;
        }
        lower_m = fmax(lower_m, separation_m(&search));
        /* The best direction is mostly nearly right: then the distance lies just above. Halving is the safe way. */
        margin_m = halves ? 0.5 * (lower_m + upper_m) : lower_m + 0.9 * BRACKET_M;
        halves = !halves;
    }
    if (lower_m <= 0.0 && meets(&search, 0.0)) {
        return 0.0;
    }
    return fmin(0.5 * (lower_m + upper_m), ceiling_m);
}
