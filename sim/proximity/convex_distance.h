/* The distance between two convex shapes. libccd's GJK decides whether the shapes meet when one of them is inflated by
 * a margin. The margin at which they just meet is the distance; it is found by bisection. */
#ifndef COMANIP_SIM_CONVEX_DISTANCE_H
#define COMANIP_SIM_CONVEX_DISTANCE_H

#include "convex_shape.h"

/* Error bound for shapes up to 1 m in size and up to 1 m apart. */
#define CONVEX_DISTANCE_ERROR_M 0.00005

/* Returns the distance, 0 if the shapes touch or overlap, and ceiling_m if they are farther apart. guess_m: distance at
 * an earlier instant, or negative if unknown. It speeds up the search, and changes the result by no more than the error
 * bound. */
double convex_distance_m(const convex_shape_t *a, const convex_shape_t *b, double ceiling_m, double guess_m);

#endif
