/* A convex shape as libccd sees it: a function that gives its furthest point in a direction. In mm: libccd compares
 * products of lengths with fixed thresholds (2e-16), which in metres are not small beside those of a hand. */
#ifndef COMANIP_SIM_CONVEX_SUPPORT_H
#define COMANIP_SIM_CONVEX_SUPPORT_H

#include <ccd/ccd.h>

#include "convex_shape.h"

#define MM_PER_M 1000.0

/* Every direction that is tried bounds the distance of the two shapes from below; this is the best one. */
typedef struct {
    double first_reach_mm; /* of the first shape in the direction that is being tried */
    double distance_mm;    /* at least so far apart */
    double direction[3];   /* from the first shape to the second; any length */
} convex_separation_t;

typedef struct {
    const convex_shape_t *shape;
    double rotation[3][3];
    double position_mm[3]; /* from the first shape's origin */
    double round_mm;       /* the shape is grown by so much: a capsule is a grown line */
    double margin_mm;      /* and by so much, which is not its own */
    convex_separation_t *separation;
} convex_operand_t;

/* Two shapes, ungrown. separation: starts with nothing known and the direction between their origins. Both shapes and
 * `separation` must outlive the operands. */
void convex_operands_init(convex_operand_t *first, convex_operand_t *second, const convex_shape_t *a,
                          const convex_shape_t *b, convex_separation_t *separation);

/* How far the first shape would have to move against the unit direction to leave the second one behind; negative: so
 * far apart they are in this direction. furthest_mm: the point of the Minkowski difference that says so. */
double convex_reach_mm(const convex_operand_t *first, const convex_operand_t *second, const double direction[3],
                       double furthest_mm[3]);

/* libccd set up for these two: pass `first` and `second` in this order. The margin is the first one's. */
void convex_support_configure(ccd_t *ccd);

#endif
