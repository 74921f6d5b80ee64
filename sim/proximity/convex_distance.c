#include "convex_distance.h"

#include <math.h>
#include <stdbool.h>

#include "convex_support.h"

/* The bisection ends when its bracket is this narrow. The result is the centre of the bracket, which is wrong by at
 * most 0.8 times the error bound. The remaining fifth of the bound allows for rounding errors. */
#define BRACKET_M (1.6 * CONVEX_DISTANCE_ERROR_M)

typedef struct {
    ccd_t ccd;
    convex_operand_t first, second;
    convex_separation_t separation;
} search_t;

/* Returns the distance between the bounding spheres, which is negative if they overlap. */
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

/* Returns true if the shapes intersect when one of them is inflated by the margin, that is, if no direction separates
 * them. If GJK ends without finding such a direction, the shapes touch to within rounding error. */
static bool intersects(search_t *self, double margin_m) {
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
    bool halve = false;
    while (upper_m - lower_m > BRACKET_M) {
        if (!(margin_m > lower_m && margin_m < upper_m)) {
            margin_m = 0.5 * (lower_m + upper_m);
        }
        if (intersects(&search, margin_m)) {
            upper_m = margin_m;
        }
        lower_m = fmax(lower_m, separation_m(&search));
        /* The best direction is usually nearly exact, so the distance is just above lower_m. Halving the bracket in
         * every second step guarantees convergence. */
        margin_m = halve ? 0.5 * (lower_m + upper_m) : lower_m + 0.9 * BRACKET_M;
        halve = !halve;
    }
    if (lower_m <= 0.0 && intersects(&search, 0.0)) {
        return 0.0;
    }
    return fmin(0.5 * (lower_m + upper_m), ceiling_m);
}
