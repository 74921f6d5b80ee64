/* Computes the impulses of all contacts in one step. The impulses separate overlapping particles, brake approaching
 * particles, and never pull particles together. A contact is a spring and a damper in parallel, integrated implicitly,
 * with ODE's equations (ODE User Guide, "How To Use ERP and CFM"). All contacts of a step are solved together, by
 * projected Gauss-Seidel iteration with over-relaxation. The iteration starts from the impulses of the previous step
 * (warm starting), so that the solution improves from step to step while the particles rest (Catto, Iterative Dynamics
 * with Temporal Coherence, GDC 2005). */
#ifndef COMANIP_SIM_PARTICLE_SOLVER_H
#define COMANIP_SIM_PARTICLE_SOLVER_H

#include "particle_contacts.h"

typedef struct particle_solver particle_solver_t;

/* The walls' indices follow those of the particles. mass_kg: mass of a particle of mean size. Returns NULL if out of
 * memory. */
particle_solver_t *particle_solver_create(int particles, int walls, double mass_kg);
void particle_solver_destroy(particle_solver_t *self);

/* Changes the velocities in particle[], which holds the particles and then the walls; walls have an inverse mass of 0.
 * Writes the contacts' impulses. There must be at most one contact per pair. */
void particle_solver_step(particle_solver_t *self, particle_contact_t contact[], int contacts, particle_t particle[],
                          double step_s);

#endif
