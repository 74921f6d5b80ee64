#include "particle_solver.h"

#include <stdint.h>
#include <stdlib.h>

/* With this stiffness the lowest particles of a full cup are compressed by about 3 % of their radius. The damping
 * prevents bouncing. Both are divided by the mass of a particle of mean size, so their units are 1/s^2 and 1/s, and the
 * behaviour does not depend on the size of the particles. */
#define STIFFNESS_PER_KG 6.0e5
#define DAMPING_PER_KG 1.5e3

#define ITERATIONS 4 /* more iterations do not change the pouring (docs/physics.md) */
#define OVER_RELAXATION 1.3

typedef struct {
    double impulse_Ns;
    uint64_t step; /* last step in which the contact was found */
} memory_t;

struct particle_solver {
    size_t bodies; /* particles and walls */
    double mass_kg;
    uint64_t step;
    memory_t memory[]; /* [particles][bodies], one for each pair */
};

/* ODE's ERP and CFM, each divided by the step. */
typedef struct {
    double correction_ps; /* separating speed per overlap, 1/s */
    double softness_pkg;  /* yielding speed per impulse, 1/kg */
} softness_t;

particle_solver_t *particle_solver_create(int particles, int walls, double mass_kg) {
    const size_t bodies = (size_t)(particles + walls);
    particle_solver_t *self = calloc(1, sizeof *self + (size_t)particles * bodies * sizeof self->memory[0]);
    if (self == NULL) {
        return NULL;
    }
    self->bodies = bodies;
    self->mass_kg = mass_kg;
    self->step = 1; /* so that the zeros from calloc() count as outdated */
    return self;
}

void particle_solver_destroy(particle_solver_t *self) {
    free(self);
}

static softness_t softness(const particle_solver_t *self, double step_s) {
    const double spring = self->mass_kg * STIFFNESS_PER_KG * step_s;
    const double damper = self->mass_kg * DAMPING_PER_KG;
    return (softness_t){.correction_ps = spring / (spring + damper) / step_s,
                        .softness_pkg = 1.0 / (step_s * (spring + damper))};
}

static memory_t *memory_of(particle_solver_t *self, const particle_contact_t *contact) {
    return &self->memory[(size_t)contact->one * self->bodies + (size_t)contact->other];
}

/* Applies the impulse to both bodies with opposite signs. */
static inline void push(const particle_contact_t *contact, double impulse_Ns, particle_t *one, particle_t *other) {
    const double one_mps = impulse_Ns * one->inverse_mass_pkg;
    const double other_mps = impulse_Ns * other->inverse_mass_pkg;
    one->velocity_mps[0] += one_mps * contact->normal[0];
    one->velocity_mps[1] += one_mps * contact->normal[1];
    one->velocity_mps[2] += one_mps * contact->normal[2];
    other->velocity_mps[0] -= other_mps * contact->normal[0];
    other->velocity_mps[1] -= other_mps * contact->normal[1];
    other->velocity_mps[2] -= other_mps * contact->normal[2];
}

static inline void solve(particle_contact_t *contact, const softness_t *soft, particle_t *one, particle_t *other) {
    const double *n = contact->normal;
    const double *a = one->velocity_mps;
    const double *b = other->velocity_mps;
    const double speed_mps = n[0] * (a[0] - b[0]) + n[1] * (a[1] - b[1]) + n[2] * (a[2] - b[2]);
    const double required_mps = soft->correction_ps * contact->depth_m + contact->wall_speed_mps;
    const double missing_mps = required_mps - speed_mps - soft->softness_pkg * contact->impulse_Ns;
    const double mass_kg = 1.0 / (one->inverse_mass_pkg + other->inverse_mass_pkg + soft->softness_pkg);
    const double before_Ns = contact->impulse_Ns;
    const double after_Ns = before_Ns + OVER_RELAXATION * mass_kg * missing_mps;
    contact->impulse_Ns = after_Ns > 0.0 ? after_Ns : 0.0;
    push(contact, contact->impulse_Ns - before_Ns, one, other);
}

static void start_from_last_step(particle_solver_t *self, particle_contact_t contact[], int contacts,
                                 particle_t particle[]) {
    for (int i = 0; i < contacts; i++) {
        const memory_t *last = memory_of(self, &contact[i]);
        contact[i].impulse_Ns = last->step + 1 == self->step ? last->impulse_Ns : 0.0;
        push(&contact[i], contact[i].impulse_Ns, &particle[contact[i].one], &particle[contact[i].other]);
    }
}

void particle_solver_step(particle_solver_t *self, particle_contact_t contact[], int contacts, particle_t particle[],
                          double step_s) {
    const softness_t soft = softness(self, step_s);
    self->step++;
    start_from_last_step(self, contact, contacts, particle);
    for (int k = 0; k < ITERATIONS; k++) {
        for (int i = 0; i < contacts; i++) {
            solve(&contact[i], &soft, &particle[contact[i].one], &particle[contact[i].other]);
        }
    }
    for (int i = 0; i < contacts; i++) {
        *memory_of(self, &contact[i]) = (memory_t){contact[i].impulse_Ns, self->step};
    }
}
