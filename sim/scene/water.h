/* Water, modelled as frictionless particles. They collide with each other and with the cups (cup.h), fall under
 * gravity, come to rest where they reach the ground, and do not act on the cups. Their radii differ from the mean by up
 * to 20 %, because particles of equal size settle into layers that do not flow. They still behave like beads rather
 * than a liquid: a heap has a slope of about 15 degrees, and the rim holds back particles by up to their diameter, so
 * less flows out of a tilted cup than with a liquid. */
#ifndef COMANIP_SIM_WATER_H
#define COMANIP_SIM_WATER_H

#include "../scenario/scenario.h"

#define WATER_MAX_CUPS 2

/* Each particle is counted in exactly one of the first three members. It counts as inside a cup from the moment at
 * which its centre enters the inner cylinder until cup_is_left_by() returns true. A particle that lies on the heap or
 * on the rim therefore still counts as inside. */
typedef struct {
    int in_robot_cup;   /* cup 0 */
    int in_person_cup;  /* cup 1 */
    int elsewhere;      /* in the air, or spilt on the ground */
    int left_robot_cup; /* all particles except in_robot_cup, so those that fell back in do not count */
} water_count_t;

typedef struct water_body water_body_t;

/* There must be at least one particle; particle_radius_m is the mean radius. All particles start in cups[0], already
 * settled. cups[1] may be absent (present = false). pose: poses of the cups, in torso axes. ground_z_m: height of the
 * ground. Returns NULL if out of memory or if the particles do not fit. */
water_body_t *water_create(const water_t *water, const cup_t cups[WATER_MAX_CUPS],
                           const rigid_pose_t pose[WATER_MAX_CUPS], double ground_z_m);
void water_destroy(water_body_t *self);

/* Makes one step, during which the cups move to `pose`. */
void water_step(water_body_t *self, const rigid_pose_t pose[WATER_MAX_CUPS], double step_s);

water_count_t water_count(const water_body_t *self);

/* Return the position and the radius of a particle (0 .. particles - 1). */
void water_particle(const water_body_t *self, int particle, double position_m[3]);
double water_particle_radius_m(const water_body_t *self, int particle);

#endif
