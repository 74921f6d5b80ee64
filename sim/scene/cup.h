/* The shell of a cup (its bottom and wall), for contacts with particles. The shell's centre line runs along the bottom
 * to the corner and up to the rim. Rotating this line about the cup's axis and thickening it produces a rounded shell.
 * The shell lies outside the cup's inner surface, so that the inner radius and height are exactly those of cup_t.
 * Points are in the cup's frame unless stated otherwise. */
#ifndef COMANIP_SIM_CUP_H
#define COMANIP_SIM_CUP_H

#include <stdbool.h>

#include "../scenario/scenario.h"

#define CUP_MAX_CONTACTS 2 /* bottom and wall */

typedef struct {
    double point_m[3]; /* on the shell */
    double normal[3];  /* unit, from the shell into the sphere */
    double depth_m;
} cup_contact_t;

/* A cup with its pose at one instant. */
typedef struct {
    const cup_t *cup;
    double position_m[3];
    double rotation[3][3];
} placed_cup_t;

placed_cup_t cup_place(const cup_t *cup, const rigid_pose_t *pose);

/* Transform a point from the world to the cup's frame and back, and a direction from the cup's frame to the world. */
void cup_from_world(const placed_cup_t *self, const double point_m[3], double in_cup_m[3]);
void cup_to_world(const placed_cup_t *self, const double in_cup_m[3], double point_m[3]);
void cup_rotate_to_world(const placed_cup_t *self, const double direction[3], double turned[3]);

/* Finds where a sphere overlaps the shell and returns the number of contacts. The result is exact unless the centre is
 * within the shell or the sphere is wider than the cup. */
int cup_touch(const cup_t *self, const double centre_m[3], double radius_m, cup_contact_t contact[CUP_MAX_CONTACTS]);

/* Computes positions for the centres of `count` spheres, layer upon layer from the bottom of the cup, and above the rim
 * if necessary. Returns the height of the last layer, or 0 if the cup is too narrow for a single sphere. */
double cup_lattice(const cup_t *self, double radius_m, int count, double point_m[][3]);

/* Returns true if the centre of a particle, centre_m, is in the cup's inner cylinder. */
bool cup_contains(const cup_t *self, const double centre_m[3]);

/* Returns true if a particle that was in the cup has left it, that is, if it is outside the wall and below the rim, or
 * farther from the inner cylinder than the particle's diameter plus the wall thickness. Until then the particle may lie
 * on the heap or on the rim, and may fall back. */
bool cup_is_left_by(const cup_t *self, const double centre_m[3], double radius_m);

#endif
