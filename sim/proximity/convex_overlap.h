/* How deep two convex shapes overlap. */
#ifndef COMANIP_SIM_CONVEX_OVERLAP_H
#define COMANIP_SIM_CONVEX_OVERLAP_H

#include "convex_shape.h"

#define CONVEX_OVERLAP_ERROR_M 0.0003

/* The shortest way that separates them, 0: they do not overlap. Never too little; mostly exact to 10 um, too much by
 * CONVEX_OVERLAP_ERROR_M at most (found with random boxes and hulls, not proven). */
double convex_overlap_m(const convex_shape_t *a, const convex_shape_t *b);

#endif
