/* Water as frictionless particles: they collide with each other and with the cups (cup.h), feel gravity, come to rest
 * where they reach the ground, and do not act on the cups. Their sizes differ by up to 20 %: equal ones settle into
 * layers that do not flow. Even so they are beads and no liquid: a heap stands some 15 degrees steep, and the rim holds
 * it back by up to a particle's diameter, so that less leaves a tilted cup than of a liquid. */
#ifndef COMANIP_SIM_WATER_H
#define COMANIP_SIM_WATER_H

#include "../scenario/scenario.h"

#define WATER_MAX_CUPS 2

/* Each particle is in one of the three. It is in a cup from when its centre comes into the inner cylinder until it has
 * left (cup_is_left_by): on the heap and on the rim it still counts as in. */
typedef struct {
    int in_robot_cup;   /* cup 0 */
    int in_person_cup;  /* cup 1 */
    int elsewhere;      /* in the air, or spilt on the ground */
    int left_robot_cup; /* all but in_robot_cup: what falls back in has not left */
} water_count_t;

typedef struct water_body water_body_t;

/* At least one particle, of mean radius particle_radius_m. cups[0]: filled at the start, particles at rest after some
 * settling; cups[1]: may be absent (present = false). pose: of the cups, torso axes. ground_z_m: where spilt water
 * ends. NULL: no memory, or the particles do not fit. */
water_body_t *water_create(const water_t *water, const cup_t cups[WATER_MAX_CUPS],
                           const rigid_pose_t pose[WATER_MAX_CUPS], double ground_z_m);
void water_destroy(water_body_t *self);

/* The cups move to `pose` during this step. */
void water_step(water_body_t *self, const rigid_pose_t pose[WATER_MAX_CUPS], double step_s);

water_count_t water_count(const water_body_t *self);

/* Of particle i (0 .. particles - 1). */
void water_particle(const water_body_t *self, int particle, double position_m[3]);
double water_particle_radius_m(const water_body_t *self, int particle);

#endif
