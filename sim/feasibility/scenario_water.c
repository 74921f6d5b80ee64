/* Checks that the water fits the robot's cup. */
#include <math.h>
#include <stdio.h>

#include "../scene/scene.h"
#include "scenario_geometry.h"

#define PACKING_MAX 0.64 /* volume of the spheres divided by that of the cup, for random close packing */

static bool check_volume(const scenario_t *self, char error[], size_t error_size) {
    const double r = self->water.particle_radius_m, radius_m = self->cup.radius_m;
    const double cup_m3 = ROBOT_PI * radius_m * radius_m * self->cup.height_m;
    const double most = PACKING_MAX * cup_m3 / (4.0 / 3.0 * ROBOT_PI * r * r * r);
    if (r >= radius_m) {
        (void)snprintf(error, error_size, "%s: water.particle_radius_m '%g': expected less than the robot cup's %g m",
                       self->path, r, radius_m);
        return false;
    }
    if (self->water.particles > most) {
        (void)snprintf(error, error_size,
                       "%s: water.particles '%d': expected at most %.0f, which fill the robot's cup to the rim",
                       self->path, self->water.particles, floor(most));
        return false;
    }
    return true;
}

/* Checks that no water spills while the water settles. Even water that check_volume() accepts may overflow, because the
 * particles heap up and the cup may be tilted. */
static bool check_settled(const scenario_t *self, char error[], size_t error_size) {
    events_t events = self->events;
    scene_t *scene = scene_create(self, &events);
    const bool stays = scene != NULL;
    scene_destroy(scene);
    if (!stays) {
        (void)snprintf(
            error, error_size,
            "%s: water.particles '%d': expected fewer, or an upright cup; some spill over the rim while they settle",
            self->path, self->water.particles);
    }
    return stays;
}

bool scenario_check_water(const scenario_t *self, char error[], size_t error_size) {
    return self->water.particles == 0 ||
           (check_volume(self, error, error_size) && check_settled(self, error, error_size));
}
