#include "convex_shape.h"

#include <math.h>

void convex_shape_finish(convex_shape_t *self) {
    const double half_length_m = 0.5 * self->length_m;
    const double *s = self->size_m;
    self->bounding_radius_m = 0.0;
    switch (self->kind) {
    case SHAPE_BOX: self->bounding_radius_m = 0.5 * sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]); break;
    case SHAPE_CAPSULE: self->bounding_radius_m = half_length_m + self->radius_m; break;
    case SHAPE_CYLINDER: self->bounding_radius_m = hypot(half_length_m, self->radius_m); break;
    case SHAPE_HULL:
        for (int i = 0; i < self->point_count; i++) {
            const double *p = self->points[i];
            self->bounding_radius_m = fmax(self->bounding_radius_m, sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]));
        }
        break;
    }
}
