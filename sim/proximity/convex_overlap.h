/* The penetration depth of two convex shapes. */
#ifndef COMANIP_SIM_CONVEX_OVERLAP_H
#define COMANIP_SIM_CONVEX_OVERLAP_H

#include "convex_shape.h"

#define CONVEX_OVERLAP_ERROR_M 0.0003

/* Returns the length of the shortest displacement that separates the shapes, or 0 if they do not overlap. The result is
 * never too small. It is usually exact to 10 um, and at most CONVEX_OVERLAP_ERROR_M too large (found with random boxes
 * and hulls, not proven). */
double convex_overlap_m(const convex_shape_t *a, const convex_shape_t *b);

#endif
