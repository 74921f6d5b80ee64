#include "water.h"

#include <math.h>
#include <stdlib.h>

#include "cup.h"
#include "particle_contacts.h"
#include "particle_solver.h"
#include "physics.h"

/* Particles of equal size would settle into crystalline layers that do not flow. The sizes are therefore derived from
 * multiples of the golden ratio, whose fractional parts are evenly spread. */
#define SIZE_SPREAD 0.2 /* radii differ from the mean by up to this share */
#define GOLDEN_RATIO 0.61803398875

#define SETTLING_STEP_S 1.0e-3
#define SETTLING_STEPS 1000
#define SETTLING_STEPS_IN_OPEN_CUP 200

struct water_body {
    cup_t cup[WATER_MAX_CUPS];
    rigid_pose_t pose[WATER_MAX_CUPS];
    double ground_z_m;
    int count;
    int sorted_count;
    particle_t *particle;       /* [count], followed by the cups' walls */
    particle_along_x_t *sorted; /* [sorted_count]: the particles that are not spilt */
    particle_contact_t *contact;
    particle_solver_t *solver;
};

/* ---- positions of the particles */

static void follow(particle_t *particle, const placed_cup_t cup[WATER_MAX_CUPS]) {
    for (int i = 0; i < WATER_MAX_CUPS; i++) {
        double in_cup_m[3];
        if (!cup[i].cup->present) {
            continue;
        }
        cup_from_world(&cup[i], particle->position_m, in_cup_m);
        if (cup_contains(cup[i].cup, in_cup_m)) {
            particle->cup = i;
        } else if (particle->cup == i && cup_is_left_by(cup[i].cup, in_cup_m, particle->radius_m)) {
            particle->cup = NO_CUP;
        }
    }
}

/* Marks a particle that has reached the ground as spilt. A spilt particle stays where it is and is no longer
 * simulated. */
static void spill(particle_t *particle, double ground_z_m) {
    if (particle->position_m[2] < ground_z_m + particle->radius_m) {
        particle->is_spilt = true;
        particle->cup = NO_CUP;
    }
}

/* ---- steps */

static int find_contacts(water_body_t *self, const placed_cup_t before[WATER_MAX_CUPS],
                         const placed_cup_t after[WATER_MAX_CUPS], double step_s) {
    int found = particle_contacts_find(self->particle, self->sorted, &self->sorted_count, self->contact);
    for (int i = 0; i < WATER_MAX_CUPS; i++) {
        if (self->cup[i].present) {
            found += particle_contacts_find_cup(self->particle, self->count, &before[i], &after[i], step_s,
                                                self->count + i * CUP_MAX_CONTACTS, &self->contact[found]);
        }
    }
    return found;
}

static void fall(water_body_t *self, double step_s) {
    for (int i = 0; i < self->count; i++) {
        if (!self->particle[i].is_spilt) {
            self->particle[i].velocity_mps[2] -= PHYSICS_GRAVITY_MPS2 * step_s;
        }
    }
}

static void move(water_body_t *self, const placed_cup_t cup[WATER_MAX_CUPS], double step_s) {
    for (int i = 0; i < self->count; i++) {
        particle_t *particle = &self->particle[i];
        if (!particle->is_spilt) {
            for (int k = 0; k < 3; k++) {
                particle->position_m[k] += particle->velocity_mps[k] * step_s;
            }
            follow(particle, cup);
            spill(particle, self->ground_z_m);
        }
    }
}

/* Uses the semi-implicit Euler method: computes the new velocities first, and then moves the particles with them. */
void water_step(water_body_t *self, const rigid_pose_t pose[WATER_MAX_CUPS], double step_s) {
    placed_cup_t before[WATER_MAX_CUPS], after[WATER_MAX_CUPS];
    for (int i = 0; i < WATER_MAX_CUPS; i++) {
        before[i] = cup_place(&self->cup[i], &self->pose[i]);
        after[i] = cup_place(&self->cup[i], &pose[i]);
        self->pose[i] = pose[i];
    }
    const int contacts = find_contacts(self, before, after, step_s);
    fall(self, step_s);
    particle_solver_step(self->solver, self->contact, contacts, self->particle, step_s);
    move(self, after, step_s);
}

/* ---- filling */

static void settle(water_body_t *self, int steps) {
    const rigid_pose_t still[WATER_MAX_CUPS] = {self->pose[0], self->pose[1]};
    for (int i = 0; i < steps; i++) {
        water_step(self, still, SETTLING_STEP_S);
    }
}

/* Lets the particles settle from a lattice, first with the cup's wall raised to the height of the lattice, and then in
 * the cup itself. Returns false if the cup is too narrow or if some particles fell over the rim. */
static bool fill(water_body_t *self, double largest_m, double point_m[][3]) {
    cup_t *cup = &self->cup[0];
    const placed_cup_t placed = cup_place(cup, &self->pose[0]);
    const double height_m = cup->height_m;
    const double lattice_m = cup_lattice(cup, largest_m, self->count, point_m);
    for (int i = 0; i < self->count && lattice_m > 0.0; i++) {
        cup_to_world(&placed, point_m[i], self->particle[i].position_m);
    }
    cup->height_m = fmax(height_m, lattice_m + largest_m);
    settle(self, lattice_m > 0.0 ? SETTLING_STEPS : 0);
    cup->height_m = height_m;
    settle(self, lattice_m > 0.0 ? SETTLING_STEPS_IN_OPEN_CUP : 0);
    return lattice_m > 0.0 && water_count(self).in_robot_cup == self->count;
}

static double mass_kg(const water_t *water, double radius_m) {
    return 4.0 / 3.0 * ROBOT_PI * radius_m * radius_m * radius_m * water->density_kgpm3;
}

static void create_particles(water_body_t *self, const water_t *water) {
    for (int i = 0; i < self->count; i++) {
        const double spread = SIZE_SPREAD * (2.0 * fmod(GOLDEN_RATIO * (i + 1), 1.0) - 1.0);
        const double radius_m = water->particle_radius_m * (1.0 + spread);
        self->particle[i] =
            (particle_t){.radius_m = radius_m, .inverse_mass_pkg = 1.0 / mass_kg(water, radius_m), .cup = 0};
        self->sorted[i].particle = i;
    }
    self->sorted_count = self->count;
}

/* ---- create, destroy, read */

static bool allocate(water_body_t *self, const water_t *water) {
    const size_t count = (size_t)self->count;
    const size_t walls = WATER_MAX_CUPS * CUP_MAX_CONTACTS;
    const size_t most_contacts = count * (count - 1) / 2 + count * walls;
    self->particle = calloc(count + walls, sizeof *self->particle);
    self->sorted = calloc(count, sizeof *self->sorted);
    self->contact = calloc(most_contacts, sizeof *self->contact);
    self->solver = particle_solver_create(self->count, (int)walls, mass_kg(water, water->particle_radius_m));
    return self->particle != NULL && self->sorted != NULL && self->contact != NULL && self->solver != NULL;
}

water_body_t *water_create(const water_t *water, const cup_t cups[WATER_MAX_CUPS],
                           const rigid_pose_t pose[WATER_MAX_CUPS], double ground_z_m) {
    water_body_t *self = calloc(1, sizeof *self);
    double (*point_m)[3] = calloc((size_t)water->particles, sizeof *point_m);
    if (self == NULL || point_m == NULL) {
        free(point_m);
        free(self);
        return NULL;
    }
    for (int i = 0; i < WATER_MAX_CUPS; i++) {
        self->cup[i] = cups[i];
        self->pose[i] = pose[i];
    }
    self->ground_z_m = ground_z_m;
    self->count = water->particles;
    bool is_full = allocate(self, water);
    if (is_full) {
        create_particles(self, water);
        is_full = fill(self, water->particle_radius_m * (1.0 + SIZE_SPREAD), point_m);
    }
    free(point_m);
    if (!is_full) {
        water_destroy(self);
        return NULL;
    }
    return self;
}

void water_destroy(water_body_t *self) {
    if (self != NULL) {
        particle_solver_destroy(self->solver);
        free(self->contact);
        free(self->sorted);
        free(self->particle);
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
    const double *position = self->particle[particle].position_m;
    for (int i = 0; i < 3; i++) {
        position_m[i] = position[i];
    }
}

double water_particle_radius_m(const water_body_t *self, int particle) {
    return self->particle[particle].radius_m;
}
