/* The wall of a cup as particles feel it: the polyline bottom-corner-rim, turned about the cup's axis and thickened to
 * a rounded shell. The shell lies outside the inner surface, so that inner radius and height are the cup's. Points are
 * in the cup's frame unless said otherwise. */
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

/* A cup where it is at one instant. */
typedef struct {
    const cup_t *cup;
    double position_m[3];
    double rotation[3][3];
} placed_cup_t;

placed_cup_t cup_place(const cup_t *cup, const rigid_pose_t *pose);

/* World to cup's frame, and back; of a direction: back only. */
void cup_see(const placed_cup_t *self, const double point_m[3], double seen_m[3]);
void cup_unsee(const placed_cup_t *self, const double seen_m[3], double point_m[3]);
void cup_turn(const placed_cup_t *self, const double direction[3], double turned[3]);

/* Where a sphere overlaps the shell; returns how many contacts. Exact unless the centre is within the shell, or the
 * sphere is wider than the cup. */
int cup_touch(const cup_t *self, const double centre_m[3], double radius_m, cup_contact_t contact[CUP_MAX_CONTACTS]);

/* Points for the centres of `count` spheres in the cup: layer upon layer from the bottom, beyond the rim if there are
 * so many. Returns the height of the last layer; 0: the cup is too narrow for one sphere. */
double cup_lattice(const cup_t *self, double radius_m, int count, double point_m[][3]);

/* The centre of a particle is in the cup's inner cylinder. */
bool cup_contains(const cup_t *self, const double centre_m[3]);

/* A particle that was in the cup is no longer: outside its wall and below its rim, or further than the particle's
 * diameter and the wall from the inner cylinder. Until then it lies on the heap or the rim and may yet fall back. */
bool cup_is_left_by(const cup_t *self, const double centre_m[3], double radius_m);

#endif
