/* What presses particles apart and off the cups' walls: ODE's contact joints for one step. */
#ifndef COMANIP_SIM_PARTICLE_CONTACTS_H
#define COMANIP_SIM_PARTICLE_CONTACTS_H

#include <ode/ode.h>
#include <stdbool.h>

#include "cup.h"

typedef struct {
    dBodyID body;
    double radius_m;
    int cup; /* that holds it, or NO_CUP */
    bool is_spilt;
} particle_t;

#define NO_CUP (-1)

/* Where the joints of one step go, and what they are like. */
typedef struct {
    dWorldID world;
    dJointGroupID joints;
    dContact contact;
    double step_s;
} particle_contacts_t;

/* mass_kg: of a particle of mean size. */
particle_contacts_t particle_contacts(dWorldID world, dJointGroupID joints, double mass_kg, double step_s);

/* Of the particles with each other. */
void particle_contacts_add(const particle_contacts_t *self, const particle_t particle[], int count);

/* Of the particles with a cup that moves from `before` to `after` within the step. */
void particle_contacts_add_cup(const particle_contacts_t *self, const particle_t particle[], int count,
                               const placed_cup_t *before, const placed_cup_t *after);

#endif
