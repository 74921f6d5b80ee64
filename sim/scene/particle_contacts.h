/* Finds the contacts of the particles with each other and with the cups' walls. */
#ifndef COMANIP_SIM_PARTICLE_CONTACTS_H
#define COMANIP_SIM_PARTICLE_CONTACTS_H

#include "cup.h"
#include "particle.h"

typedef struct {
    int one;               /* a particle's index */
    int other;             /* index of another particle (less than `one`), or of a wall */
    double normal[3];      /* unit, from `other` into `one` */
    double depth_m;        /* depth of the overlap, > 0 */
    double wall_speed_mps; /* speed of the wall along the normal; 0 between particles */
    double impulse_Ns;     /* impulse on `one` along the normal, >= 0; written by the solver */
} particle_contact_t;

/* An entry of the list of particles sorted along x. */
typedef struct {
    double position_m[3];
    double radius_m;
    int particle; /* the particle's index */
} particle_along_x_t;

/* Finds the contacts between particles. sorted[] lists the *sorted_count particles that are not spilt, in the order
 * left by the last call. Before the first call, the order is arbitrary, and only the member `particle` needs to be
 * set. Removes from the list the particles spilt since the last call. Returns the number of contacts, at most one per
 * pair. */
int particle_contacts_find(const particle_t particle[], particle_along_x_t sorted[], int *sorted_count,
                           particle_contact_t contact[]);

/* Finds the contacts with a cup that moves from `before` to `after` within the step. A particle's contacts with the cup
 * get the wall indices first_wall, first_wall + 1. Returns the number of contacts, at most CUP_MAX_CONTACTS per
 * particle. */
int particle_contacts_find_cup(const particle_t particle[], int count, const placed_cup_t *before,
                               const placed_cup_t *after, double step_s, int first_wall, particle_contact_t contact[]);

#endif
