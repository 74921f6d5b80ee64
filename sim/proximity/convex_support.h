/* Support functions of convex shapes for libccd: the farthest point in a direction. Lengths are in mm, because libccd
 * compares products of lengths with fixed thresholds (2e-16), which are too coarse for hand-sized shapes measured in
 * metres. */
#ifndef COMANIP_SIM_CONVEX_SUPPORT_H
#define COMANIP_SIM_CONVEX_SUPPORT_H

#include <ccd/ccd.h>

#include "convex_shape.h"

#define MM_PER_M 1000.0

/* The best lower bound of the distance between the two shapes so far. Every direction that libccd tries provides a
 * bound. */
typedef struct {
    double first_reach_mm; /* reach of the first shape in the current direction */
    double distance_mm;    /* lower bound of the distance */
    double direction[3];   /* direction that yields distance_mm, from the first shape to the second; any length */
} convex_separation_t;

typedef struct {
    const convex_shape_t *shape;
    double rotation[3][3];
    double position_mm[3]; /* from the first shape's origin */
    double round_mm;       /* radius by which the core is inflated: a capsule is an inflated line; 0 for other shapes */
    double margin_mm;      /* additional inflation for the search */
    convex_separation_t *separation;
} convex_operand_t;

/* Initialises both operands with margin 0, and separation with distance 0 and the direction between the origins. Both
 * shapes and `separation` must outlive the operands. */
void convex_operands_init(convex_operand_t *first, convex_operand_t *second, const convex_shape_t *a,
                          const convex_shape_t *b, convex_separation_t *separation);

/* Returns how far the first shape would have to move against the unit direction to be separated from the second one. If
 * the shapes are already apart in this direction, the result is minus their distance. furthest_mm: the farthest point
 * of the Minkowski difference in this direction. */
double convex_reach_mm(const convex_operand_t *first, const convex_operand_t *second, const double direction[3],
                       double furthest_mm[3]);

/* Configures libccd for two operands, which must be passed to libccd in the order `first`, `second`. Only the first
 * operand's margin is used. */
void convex_support_configure(ccd_t *ccd);

#endif
