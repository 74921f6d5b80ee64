#include "particle_contacts.h"

#include <math.h>

/* A contact is a spring and a damper in parallel, so soft that a full cup presses its lowest particles together by some
 * 3 % of their radius, and damped so that nothing bounces. Related to a particle's mass, which makes all sizes alike:
 * 1/s^2 and 1/s. */
#define CONTACT_STIFFNESS_PER_KG 6.0e5
#define CONTACT_DAMPING_PER_KG 1.5e3

particle_contacts_t particle_contacts(dWorldID world, dJointGroupID joints, double mass_kg, double step_s) {
    const double spring = mass_kg * CONTACT_STIFFNESS_PER_KG * step_s;
    const double damper = mass_kg * CONTACT_DAMPING_PER_KG;
    return (particle_contacts_t){.world = world,
                                 .joints = joints,
                                 .contact = {.surface = {.mode = dContactSoftERP | dContactSoftCFM | dContactMotionN,
                                                         .mu = 0.0,
                                                         .soft_erp = spring / (spring + damper),
                                                         .soft_cfm = 1.0 / (spring + damper)}},
                                 .step_s = step_s};
}

static void add(const particle_contacts_t *self, const dContact *contact, dBodyID body, dBodyID other) {
    dJointAttach(dJointCreateContact(self->world, self->joints, contact), body, other);
}

static void add_pair(const particle_contacts_t *self, const particle_t *one, const particle_t *other) {
    const dReal *a = dBodyGetPosition(one->body);
    const dReal *b = dBodyGetPosition(other->body);
    const double reach_m = one->radius_m + other->radius_m;
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    const double distance_m = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    dContact contact = self->contact;
    contact.geom.depth = reach_m - distance_m;
    for (int k = 0; k < 3; k++) {
        contact.geom.normal[k] = d[k] / distance_m;
        contact.geom.pos[k] = b[k] + d[k] * other->radius_m / reach_m;
    }
    add(self, &contact, one->body, other->body);
}

/* All pairs: for a hundred particles cheaper than any search structure. */
void particle_contacts_add(const particle_contacts_t *self, const particle_t particle[], int count) {
    for (int i = 0; i < count; i++) {
        const particle_t *one = &particle[i];
        const dReal *a = dBodyGetPosition(one->body);
        for (int j = 0; j < i && !one->is_spilt; j++) {
            const particle_t *other = &particle[j];
            const dReal *b = dBodyGetPosition(other->body);
            const double reach_m = one->radius_m + other->radius_m;
            const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
            const double square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
            if (square < reach_m * reach_m && square > 0.0 && !other->is_spilt) {
                add_pair(self, one, other);
            }
        }
    }
}

static void add_wall(const particle_contacts_t *self, const cup_contact_t *touch, const placed_cup_t *before,
                     const placed_cup_t *after, dBodyID body) {
    double from_m[3], to_m[3], normal[3];
    cup_unsee(before, touch->point_m, from_m);
    cup_unsee(after, touch->point_m, to_m);
    cup_turn(before, touch->normal, normal);
    dContact contact = self->contact;
    contact.geom.depth = touch->depth_m;
    for (int k = 0; k < 3; k++) {
        contact.geom.pos[k] = from_m[k];
        contact.geom.normal[k] = normal[k];
        contact.surface.motionN += normal[k] * (to_m[k] - from_m[k]) / self->step_s;
    }
    add(self, &contact, body, NULL);
}

void particle_contacts_add_cup(const particle_contacts_t *self, const particle_t particle[], int count,
                               const placed_cup_t *before, const placed_cup_t *after) {
    for (int i = 0; i < count; i++) {
        cup_contact_t touch[CUP_MAX_CONTACTS];
        double seen_m[3];
        cup_see(before, dBodyGetPosition(particle[i].body), seen_m);
        const int touches = particle[i].is_spilt ? 0 : cup_touch(before->cup, seen_m, particle[i].radius_m, touch);
        for (int k = 0; k < touches; k++) {
            add_wall(self, &touch[k], before, after, particle[i].body);
        }
    }
}
