/* The distance between two convex shapes. libccd's GJK decides whether the shapes meet when one of them is inflated by
 * a margin. The margin at which the shapes just meet is their distance. Bisection finds this margin. */
#ifndef COMANIP_SIM_CONVEX_DISTANCE_H
#define COMANIP_SIM_CONVEX_DISTANCE_H

#include "convex_shape.h"

/* Error bound for shapes up to 1 m in size and up to 1 m apart. */
#define CONVEX_DISTANCE_ERROR_M 0.00005

/* Returns the distance: 0 if the shapes touch or overlap, and ceiling_m if they are farther apart than ceiling_m.
 * guess_m: distance at an earlier instant, or negative if unknown. A good guess speeds up the search. The guess changes
 * the result by no more than the error bound. */
double convex_distance_m(const convex_shape_t *a, const convex_shape_t *b, double ceiling_m, double guess_m);

#endif
