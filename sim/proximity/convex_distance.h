/* The distance between two convex shapes. libccd's GJK decides whether the shapes meet when one of them is inflated by
 * a margin. The margin at which they just meet is the distance; it is found by bisection. */
#ifndef COMANIP_SIM_CONVEX_DISTANCE_H
#define COMANIP_SIM_CONVEX_DISTANCE_H

#include "convex_shape.h"

/* Error bound for shapes of up to 1 m size and distance. */
#define CONVEX_DISTANCE_ERROR_M 0.00005

/* Returns the distance, 0 if the shapes touch or overlap, and ceiling_m if they are farther apart. guess_m: distance at
 * an earlier instant, or negative; it speeds up the search and does not change the result beyond the error bound. */
double convex_distance_m(const convex_shape_t *a, const convex_shape_t *b, double ceiling_m, double guess_m);

#endif
