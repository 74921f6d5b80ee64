#include "convex_support.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#define MAX_ITERATIONS 200 /* curved surfaces that touch need several dozen */

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void hull_support(const convex_shape_t *shape, const double direction[3], double point_m[3]) {
    int best = 0;
    double best_reach = dot(shape->points[0], direction);
    for (int i = 1; i < shape->point_count; i++) {
        const double reach = dot(shape->points[i], direction);
        if (reach > best_reach) {
            best_reach = reach;
            best = i;
        }
    }
    memcpy(point_m, shape->points[best], 3 * sizeof *point_m);
}

/* Finds the farthest point of the shape's core in a direction. Point and direction are in the shape's frame. The core
 * of a capsule is the capsule's centre line; the core of any other shape is the shape itself. */
static void core_support(const convex_shape_t *shape, const double direction[3], double point_m[3]) {
    double length = 0.0, share = 0.0;
    switch (shape->kind) {
    case SHAPE_BOX:
        for (int i = 0; i < 3; i++) {
            point_m[i] = copysign(0.5 * shape->size_m[i], direction[i]);
        }
        break;
    case SHAPE_CYLINDER:
        length = sqrt(direction[0] * direction[0] + direction[1] * direction[1]);
        share = length > 0.0 ? shape->radius_m / length : 0.0;
        point_m[0] = share * direction[0];
        point_m[1] = share * direction[1];
        point_m[2] = copysign(0.5 * shape->length_m, direction[2]);
        break;
    case SHAPE_CAPSULE: point_m[2] = copysign(0.5 * shape->length_m, direction[2]); break;
    case SHAPE_HULL: hull_support(shape, direction, point_m); break;
    }
}

/* Computes the support point of the inflated shape and returns how far this point reaches in the direction. */
static double inflated_support(const convex_operand_t *self, const ccd_vec3_t *direction, ccd_vec3_t *point) {
    const double *d = direction->v;
    double local[3], core_m[3] = {0.0};
    for (size_t i = 0; i < 3; i++) {
        local[i] = self->rotation[0][i] * d[0] + self->rotation[1][i] * d[1] + self->rotation[2][i] * d[2];
    }
    core_support(self->shape, local, core_m);
    const double length = sqrt(dot(d, d));
    const double growth = length > 0.0 ? (self->round_mm + self->margin_mm) / length : 0.0;
    for (size_t i = 0; i < 3; i++) {
        point->v[i] = self->position_mm[i] + MM_PER_M * dot(self->rotation[i], core_m) + growth * d[i];
    }
    return length > 0.0 ? dot(point->v, d) / length : HUGE_VAL;
}

static void support_first(const void *object, const ccd_vec3_t *direction, ccd_vec3_t *point) {
    const convex_operand_t *self = object;
    self->separation->first_reach_mm = inflated_support(self, direction, point) - self->margin_mm;
}

/* libccd calls this function after support_first(), with the opposite direction. */
static void support_second(const void *object, const ccd_vec3_t *opposite, ccd_vec3_t *point) {
    const convex_operand_t *self = object;
    convex_separation_t *separation = self->separation;
    const double distance_mm = -separation->first_reach_mm - inflated_support(self, opposite, point);
    if (distance_mm > separation->distance_mm) {
        separation->distance_mm = distance_mm;
        for (int i = 0; i < 3; i++) {
            separation->direction[i] = -opposite->v[i];
        }
    }
}

/* Starts with the best direction found so far, so that a search ends quickly if only the margin has changed since the
 * last search. */
static void first_direction(const void *first, const void *second, ccd_vec3_t *direction) {
    const convex_operand_t *self = first;
    (void)second;
    memcpy(direction->v, self->separation->direction, sizeof direction->v);
}

static void operand_init(convex_operand_t *self, const convex_shape_t *shape, const double origin_m[3],
                         convex_separation_t *separation) {
    static const double axis[3][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    self->shape = shape;
    for (int i = 0; i < 3; i++) {
        double column[3];
        rotation_apply(shape->pose.rotation, axis[i], column);
        for (int j = 0; j < 3; j++) {
            self->rotation[j][i] = column[j];
        }
        self->position_mm[i] = MM_PER_M * (shape->pose.position_m[i] - origin_m[i]);
    }
    self->round_mm = shape->kind == SHAPE_CAPSULE ? MM_PER_M * shape->radius_m : 0.0;
    self->margin_mm = 0.0;
    self->separation = separation;
}

void convex_operands_init(convex_operand_t *first, convex_operand_t *second, const convex_shape_t *a,
                          const convex_shape_t *b, convex_separation_t *separation) {
    operand_init(first, a, a->pose.position_m, separation);
    operand_init(second, b, a->pose.position_m, separation);
    *separation = (convex_separation_t){.distance_mm = 0.0};
    memcpy(separation->direction, second->position_mm, sizeof separation->direction);
    if (dot(separation->direction, separation->direction) <= 0.0) {
        separation->direction[0] = 1.0; /* the origins coincide: any direction will do */
    }
}

double convex_reach_mm(const convex_operand_t *first, const convex_operand_t *second, const double direction[3],
                       double furthest_mm[3]) {
    const ccd_vec3_t along = {{direction[0], direction[1], direction[2]}};
    const ccd_vec3_t against = {{-direction[0], -direction[1], -direction[2]}};
    ccd_vec3_t p, q;
    const double reach_mm = inflated_support(first, &along, &p) + inflated_support(second, &against, &q);
    for (int i = 0; i < 3; i++) {
        furthest_mm[i] = p.v[i] - q.v[i];
    }
    return reach_mm;
}

void convex_support_configure(ccd_t *ccd) {
    CCD_INIT(ccd);
    ccd->first_dir = first_direction;
    ccd->support1 = support_first;
    ccd->support2 = support_second;
    ccd->max_iterations = MAX_ITERATIONS;
}
