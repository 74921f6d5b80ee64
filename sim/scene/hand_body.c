#include "hand_body.h"

#include <math.h>
#include <ode/ode.h>
#include <string.h>

void hand_body_init(hand_body_t *self, dWorldID world, const person_t *person) {
    memset(self, 0, sizeof *self);
    self->mass_kg = person->mass_kg;
    self->inertia_kgm2 = person->mass_kg * PERSON_GYRATION_M * PERSON_GYRATION_M;
    self->stiffness_Npm = person->stiffness_Npm;
    self->damping_Nspm = 2.0 * person->damping_ratio * sqrt(self->stiffness_Npm * self->mass_kg);
    self->stiffness_Nmprad = person->stiffness_Nmprad;
    self->damping_Nmspprad = 2.0 * person->damping_ratio * sqrt(self->stiffness_Nmprad * self->inertia_kgm2);
    self->aim = self->next_aim = person->start;
    self->body = dBodyCreate(world);
    dMass mass;
    dMassSetParameters(&mass, self->mass_kg, 0.0, 0.0, 0.0, self->inertia_kgm2, self->inertia_kgm2, self->inertia_kgm2,
                       0.0, 0.0, 0.0);
    dBodySetMass(self->body, &mass);
    dBodySetGravityMode(self->body, 0);
    dBodySetFiniteRotationMode(self->body,
                               1); /* a step rotates the body by exactly its angular velocity times the step */
    dBodySetPosition(self->body, person->start.position_m[0], person->start.position_m[1], person->start.position_m[2]);
    dBodySetQuaternion(self->body, person->start.rotation);
}

/* Computes the rotation vector of the shorter rotation from a to b, in torso axes. */
static void rotation_vector_between(const double a[4], const double b[4], double vector_rad[3]) {
    const double from_a[4] = {a[0], -a[1], -a[2], -a[3]};
    double turn[4];
    rotation_multiply(b, from_a, turn);
    const double sine = sqrt(turn[1] * turn[1] + turn[2] * turn[2] + turn[3] * turn[3]);
    const double angle_rad = 2.0 * atan2(sine, fabs(turn[0]));
    const double scale = sine > 0.0 ? copysign(angle_rad / sine, turn[0]) : 0.0;
    for (int k = 0; k < 3; k++) {
        vector_rad[k] = scale * turn[k + 1];
    }
}

void hand_body_push(hand_body_t *self, double step_s) {
    rigid_pose_t now;
    hand_body_pose(self, &now);
    const dReal *velocity = dBodyGetLinearVel(self->body);
    const dReal *spin = dBodyGetAngularVel(self->body);
    double turn_rad[3], off_rad[3], force_N[3], torque_Nm[3];
    rotation_vector_between(self->aim.rotation, self->next_aim.rotation, turn_rad);
    rotation_vector_between(now.rotation, self->aim.rotation, off_rad);
    for (int k = 0; k < 3; k++) {
        const double next_mps = (self->next_aim.position_m[k] - self->aim.position_m[k]) / step_s;
        const double next_radps = turn_rad[k] / step_s;
        force_N[k] = self->mass_kg * (next_mps - self->aim_velocity_mps[k]) / step_s +
                     self->stiffness_Npm * (self->aim.position_m[k] - now.position_m[k]) +
                     self->damping_Nspm * (self->aim_velocity_mps[k] - velocity[k]);
        torque_Nm[k] = self->inertia_kgm2 * (next_radps - self->aim_spin_radps[k]) / step_s +
                       self->stiffness_Nmprad * off_rad[k] +
                       self->damping_Nmspprad * (self->aim_spin_radps[k] - spin[k]);
        self->aim_velocity_mps[k] = next_mps;
        self->aim_spin_radps[k] = next_radps;
    }
    dBodyAddForce(self->body, force_N[0], force_N[1], force_N[2]);
    dBodyAddTorque(self->body, torque_Nm[0], torque_Nm[1], torque_Nm[2]);
    self->aim = self->next_aim;
}

void hand_body_pose(const hand_body_t *self, rigid_pose_t *pose) {
    memcpy(pose->position_m, dBodyGetPosition(self->body), sizeof pose->position_m);
    memcpy(pose->rotation, dBodyGetQuaternion(self->body), sizeof pose->rotation);
}
