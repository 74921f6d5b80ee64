#include "water.h"

#include <math.h>
#include <ode/ode.h>
#include <stdlib.h>

#include "cup.h"
#include "particle_contacts.h"
#include "physics.h"

#define SOLVER_ITERATIONS 10 /* more change nothing that counts: the contacts are soft */

/* Particles of one size settle into crystal layers that do not flow. The golden ratio's multiples spread evenly. */
#define SIZE_SPREAD 0.2 /* radii differ from the mean by up to this share */
#define GOLDEN_RATIO 0.61803398875

#define SETTLING_STEP_S 1.0e-3
#define SETTLING_STEPS 1000
#define SETTLING_STEPS_IN_OPEN_CUP 200

struct water_body {
    dWorldID world;
    dJointGroupID contacts;
    unsigned long random; /* ODE's generator, which orders the solver's rows, as the water left it */
    cup_t cup[WATER_MAX_CUPS];
    rigid_pose_t pose[WATER_MAX_CUPS];
    double mass_kg; /* of a particle of mean size */
    double ground_z_m;
    int count;
    particle_t particle[];
};

/* ---- where the particles are */

static void follow(particle_t *particle, const placed_cup_t cup[WATER_MAX_CUPS]) {
    for (int i = 0; i < WATER_MAX_CUPS; i++) {
        double seen_m[3];
        if (!cup[i].cup->present) {
            continue;
        }
        cup_see(&cup[i], dBodyGetPosition(particle->body), seen_m);
        if (cup_contains(cup[i].cup, seen_m)) {
            particle->cup = i;
        } else if (particle->cup == i && cup_is_left_by(cup[i].cup, seen_m, particle->radius_m)) {
            particle->cup = NO_CUP;
        }
    }
}

/* What lies on the ground stays there and costs nothing. */
static void spill(particle_t *particle, double ground_z_m) {
    if (dBodyGetPosition(particle->body)[2] < ground_z_m + particle->radius_m) {
        particle->is_spilt = true;
        particle->cup = NO_CUP;
        dBodyDisable(particle->body);
    }
}

/* ---- steps */

/* The solver draws from ODE's generator, which all worlds share: the water neither feels others nor is felt by them. */
static void solve(water_body_t *self, double step_s) {
    const unsigned long others = dRandGetSeed();
    dRandSetSeed(self->random);
    dWorldQuickStep(self->world, step_s);
    self->random = dRandGetSeed();
    dRandSetSeed(others);
}

void water_step(water_body_t *self, const rigid_pose_t pose[WATER_MAX_CUPS], double step_s) {
    const particle_contacts_t contacts = particle_contacts(self->world, self->contacts, self->mass_kg, step_s);
    placed_cup_t after[WATER_MAX_CUPS];
    particle_contacts_add(&contacts, self->particle, self->count);
    for (int i = 0; i < WATER_MAX_CUPS; i++) {
        const placed_cup_t before = cup_place(&self->cup[i], &self->pose[i]);
        after[i] = cup_place(&self->cup[i], &pose[i]);
        self->pose[i] = pose[i];
        if (self->cup[i].present) {
            particle_contacts_add_cup(&contacts, self->particle, self->count, &before, &after[i]);
        }
    }
    solve(self, step_s);
    dJointGroupEmpty(self->contacts);
    for (int i = 0; i < self->count; i++) {
        if (!self->particle[i].is_spilt) {
            follow(&self->particle[i], after);
            spill(&self->particle[i], self->ground_z_m);
        }
    }
}

/* ---- filling */

static void settle(water_body_t *self, int steps) {
    const rigid_pose_t still[WATER_MAX_CUPS] = {self->pose[0], self->pose[1]};
    for (int i = 0; i < steps; i++) {
        water_step(self, still, SETTLING_STEP_S);
    }
}

/* Lets the particles sink from a lattice, at first within a collar as high as the lattice. False: the cup is too
 * narrow, or some fell over the rim. */
static bool fill(water_body_t *self, double largest_m, double point_m[][3]) {
    cup_t *cup = &self->cup[0];
    const placed_cup_t placed = cup_place(cup, &self->pose[0]);
    const double height_m = cup->height_m;
    const double lattice_m = cup_lattice(cup, largest_m, self->count, point_m);
    for (int i = 0; i < self->count && lattice_m > 0.0; i++) {
        double at_m[3];
        cup_unsee(&placed, point_m[i], at_m);
        dBodySetPosition(self->particle[i].body, at_m[0], at_m[1], at_m[2]);
    }
    cup->height_m = fmax(height_m, lattice_m + largest_m);
    settle(self, lattice_m > 0.0 ? SETTLING_STEPS : 0);
    cup->height_m = height_m;
    settle(self, lattice_m > 0.0 ? SETTLING_STEPS_IN_OPEN_CUP : 0);
    return lattice_m > 0.0 && water_count(self).in_robot_cup == self->count;
}

static void create_particles(water_body_t *self, const water_t *water) {
    dMass mass;
    dMassSetSphere(&mass, water->density_kgpm3, water->particle_radius_m);
    self->mass_kg = mass.mass;
    for (int i = 0; i < self->count; i++) {
        const double spread = SIZE_SPREAD * (2.0 * fmod(GOLDEN_RATIO * (i + 1), 1.0) - 1.0);
        const double radius_m = water->particle_radius_m * (1.0 + spread);
        const dBodyID body = dBodyCreate(self->world);
        dMassSetSphere(&mass, water->density_kgpm3, radius_m);
        dBodySetMass(body, &mass);
        dBodySetGyroscopicMode(body, 0); /* without friction nothing ever turns them */
        self->particle[i] = (particle_t){.body = body, .radius_m = radius_m, .cup = 0};
    }
}

/* ---- create, destroy, look */

water_body_t *water_create(const water_t *water, const cup_t cups[WATER_MAX_CUPS],
                           const rigid_pose_t pose[WATER_MAX_CUPS], double ground_z_m) {
    const size_t count = (size_t)water->particles;
    water_body_t *self = calloc(1, sizeof *self + count * sizeof self->particle[0]);
    double (*point_m)[3] = calloc(count, sizeof *point_m);
    if (self == NULL || point_m == NULL) {
        free(point_m);
        free(self);
        return NULL;
    }
    dInitODE2(0);
    dAllocateODEDataForThread((unsigned int)dAllocateMaskAll);
    self->world = dWorldCreate();
    self->contacts = dJointGroupCreate(0);
    dWorldSetGravity(self->world, 0.0, 0.0, -PHYSICS_GRAVITY_MPS2);
    dWorldSetQuickStepNumIterations(self->world, SOLVER_ITERATIONS);
    for (int i = 0; i < WATER_MAX_CUPS; i++) {
        self->cup[i] = cups[i];
        self->pose[i] = pose[i];
    }
    self->ground_z_m = ground_z_m;
    self->count = water->particles;
    create_particles(self, water);
    const bool is_full = fill(self, water->particle_radius_m * (1.0 + SIZE_SPREAD), point_m);
    free(point_m);
    if (!is_full) {
        water_destroy(self);
        return NULL;
    }
    return self;
}

void water_destroy(water_body_t *self) {
    if (self != NULL) {
        dJointGroupDestroy(self->contacts);
        dWorldDestroy(self->world);
        dCloseODE();
        free(self);
    }
}

water_count_t water_count(const water_body_t *self) {
    water_count_t count = {0};
    for (int i = 0; i < self->count; i++) {
        const int cup = self->particle[i].cup;
        count.in_robot_cup += cup == 0;
        count.in_person_cup += cup == 1;
        count.elsewhere += cup == NO_CUP;
        count.left_robot_cup += cup != 0;
    }
    return count;
}

void water_particle(const water_body_t *self, int particle, double position_m[3]) {
    const dReal *position = dBodyGetPosition(self->particle[particle].body);
    for (int i = 0; i < 3; i++) {
        position_m[i] = position[i];
    }
}

double water_particle_radius_m(const water_body_t *self, int particle) {
    return self->particle[particle].radius_m;
}
