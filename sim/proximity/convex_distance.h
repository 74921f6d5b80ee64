/* The distance between two convex shapes, through libccd: GJK decides whether two shapes meet when one of them is
 * inflated by a margin, and the margin at which they just meet, found by bisection, is the distance. */
#ifndef COMANIP_SIM_CONVEX_DISTANCE_H
#define COMANIP_SIM_CONVEX_DISTANCE_H

#include "convex_shape.h"

/* Bound of its error, for shapes up to 1 m across and apart. */
#define CONVEX_DISTANCE_ERROR_M 0.00005

/* Least distance, at least 0 (they touch or overlap); at most `ceiling_m`: what lies beyond is not searched. guess_m:
 * of an earlier instant, or negative; makes it faster, not different beyond the error bound. */
double convex_distance_m(const convex_shape_t *a, const convex_shape_t *b, double ceiling_m, double guess_m);

#endif
