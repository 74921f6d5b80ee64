#include "cup.h"

#include <math.h>

#define LATTICE_SPACING 2.05         /* distance of neighbouring spheres in a layer, in radii */
#define LAYER_SPACING 1.8            /* distance of layers, in radii; a layer lies in the hollows of the layer below */
#define LAYER_TURN_RAD 2.39996322973 /* golden angle between layers, so that spheres do not balance in columns */

placed_cup_t cup_place(const cup_t *cup, const rigid_pose_t *pose) {
    placed_cup_t placed = {.cup = cup};
    for (int i = 0; i < 3; i++) {
        const double axis[3] = {i == 0, i == 1, i == 2};
        double column[3];
        rotation_apply(pose->rotation, axis, column);
        placed.position_m[i] = pose->position_m[i];
        for (int k = 0; k < 3; k++) {
            placed.rotation[k][i] = column[k];
        }
    }
    return placed;
}

void cup_from_world(const placed_cup_t *self, const double point_m[3], double in_cup_m[3]) {
    const double d[3] = {point_m[0] - self->position_m[0], point_m[1] - self->position_m[1],
                         point_m[2] - self->position_m[2]};
    for (int i = 0; i < 3; i++) {
        in_cup_m[i] = self->rotation[0][i] * d[0] + self->rotation[1][i] * d[1] + self->rotation[2][i] * d[2];
    }
}

void cup_rotate_to_world(const placed_cup_t *self, const double direction[3], double turned[3]) {
    for (int i = 0; i < 3; i++) {
        const double *row = self->rotation[i];
        turned[i] = row[0] * direction[0] + row[1] * direction[1] + row[2] * direction[2];
    }
}

void cup_to_world(const placed_cup_t *self, const double in_cup_m[3], double point_m[3]) {
    cup_rotate_to_world(self, in_cup_m, point_m);
    for (int i = 0; i < 3; i++) {
        point_m[i] += self->position_m[i];
    }
}

/* A point in the half-plane through the axis and the sphere's centre: rho outwards from the axis, z along it. */
typedef struct {
    double rho, z;
} profile_t;

static double clamp(double value, double low, double high) {
    return fmin(fmax(value, low), high);
}

/* Finds the contact between a sphere and the part of the shell around one point of the wall's centre line. Returns
 * false if the two do not touch. */
static bool touch_around(profile_t on_line, double half_wall_m, profile_t centre, const double outwards[2],
                         double radius_m, cup_contact_t *contact) {
    const double rho = centre.rho - on_line.rho;
    const double z = centre.z - on_line.z;
    const double distance_m = sqrt(rho * rho + z * z);
    const double depth_m = half_wall_m + radius_m - distance_m;
    if (depth_m <= 0.0 || distance_m <= 0.0) {
        return false;
    }
    const profile_t normal = {rho / distance_m, z / distance_m};
    const double rho_on_shell = on_line.rho + half_wall_m * normal.rho;
    for (int i = 0; i < 2; i++) {
        contact->point_m[i] = rho_on_shell * outwards[i];
        contact->normal[i] = normal.rho * outwards[i];
    }
    contact->point_m[2] = on_line.z + half_wall_m * normal.z;
    contact->normal[2] = normal.z;
    contact->depth_m = depth_m;
    return true;
}

/* Returns true if a sphere certainly does not touch the shell. This test is quick, because it needs no square root, and
 * it is sufficient for most particles, which are well inside or outside the cup. */
static bool is_clear(const cup_t *self, double square, double z, double radius_m) {
    const double room_m = self->radius_m - radius_m;
    const double outer_m = self->radius_m + self->wall_m + radius_m;
    const bool is_inside = z >= radius_m && room_m > 0.0 && square <= room_m * room_m;
    return is_inside || square >= outer_m * outer_m || z >= self->height_m + radius_m || z <= -self->wall_m - radius_m;
}

int cup_touch(const cup_t *self, const double centre_m[3], double radius_m, cup_contact_t contact[CUP_MAX_CONTACTS]) {
    const double square = centre_m[0] * centre_m[0] + centre_m[1] * centre_m[1];
    if (is_clear(self, square, centre_m[2], radius_m)) {
        return 0;
    }
    const double half_wall_m = 0.5 * self->wall_m;
    const profile_t corner = {self->radius_m + half_wall_m, -half_wall_m};
    const double rim_z = self->height_m - half_wall_m;
    const double rho = sqrt(square);
    const profile_t centre = {rho, centre_m[2]};
    const double outwards[2] = {rho > 0.0 ? centre_m[0] / rho : 1.0, rho > 0.0 ? centre_m[1] / rho : 0.0};
    int count = 0;
    /* The lines of bottom and wall share the corner. A sphere outside the corner is tested only against the bottom, so
     * that its contact counts only once. */
    if (centre.rho < corner.rho || centre.z <= corner.z) {
        const profile_t on_bottom = {fmin(centre.rho, corner.rho), corner.z};
        count += touch_around(on_bottom, half_wall_m, centre, outwards, radius_m, &contact[count]);
    }
    if (centre.z > corner.z) {
        const profile_t on_wall = {corner.rho, clamp(centre.z, corner.z, rim_z)};
        count += touch_around(on_wall, half_wall_m, centre, outwards, radius_m, &contact[count]);
    }
    return count;
}

/* Fills one layer with at most `count` points. Returns how many of them fit. */
static int fill_layer(double room_m, double spacing_m, double turn_rad, double height_m, int count,
                      double point_m[][3]) {
    const int reach = 2 * (int)ceil(room_m / spacing_m);
    const double cosine = cos(turn_rad);
    const double sine = sin(turn_rad);
    int filled = 0;
    for (int row = -reach; row <= reach; row++) {
        for (int column = -reach; column <= reach && filled < count; column++) {
            const double x = spacing_m * (column + 0.5 * row);
            const double y = spacing_m * sqrt(0.75) * row;
            if (x * x + y * y <= room_m * room_m) {
                point_m[filled][0] = x * cosine - y * sine;
                point_m[filled][1] = x * sine + y * cosine;
                point_m[filled][2] = height_m;
                filled++;
            }
        }
    }
    return filled;
}

double cup_lattice(const cup_t *self, double radius_m, int count, double point_m[][3]) {
    const double room_m = self->radius_m - radius_m;
    double height_m = 0.0;
    for (int layer = 0, filled = 0; room_m >= 0.0 && filled < count; layer++) {
        height_m = radius_m * (1.0 + LAYER_SPACING * layer);
        filled += fill_layer(room_m, LATTICE_SPACING * radius_m, LAYER_TURN_RAD * layer, height_m, count - filled,
                             &point_m[filled]);
    }
    return height_m;
}

bool cup_contains(const cup_t *self, const double centre_m[3]) {
    const double square = centre_m[0] * centre_m[0] + centre_m[1] * centre_m[1];
    return square <= self->radius_m * self->radius_m && centre_m[2] >= 0.0 && centre_m[2] <= self->height_m;
}

bool cup_is_left_by(const cup_t *self, const double centre_m[3], double radius_m) {
    const double rho = sqrt(centre_m[0] * centre_m[0] + centre_m[1] * centre_m[1]);
    const double aside_m = fmax(rho - self->radius_m, 0.0);
    const double along_m = centre_m[2] - clamp(centre_m[2], 0.0, self->height_m);
    const double clear_m = 2.0 * radius_m + self->wall_m;
    const bool is_outside_wall = aside_m > self->wall_m && centre_m[2] < self->height_m;
    return is_outside_wall || aside_m * aside_m + along_m * along_m > clear_m * clear_m;
}
