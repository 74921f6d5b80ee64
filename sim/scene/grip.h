/* A grip that the object slips out of when the load exceeds a limit. The grip is an ODE ball or fixed joint between the
 * hand and the object, at the point of the object's axis nearest to the hand. The robot's pads act as springs, which
 * are modelled by the joint's ERP and CFM. The joint is integrated implicitly and is therefore stable for any
 * stiffness. A fixed grip does not yield in rotation. A person's grip is rigid, but the person's arm is compliant
 * (hand_body.h). */
#ifndef COMANIP_SIM_GRIP_H
#define COMANIP_SIM_GRIP_H

#include <ode/ode.h>
#include <stdbool.h>

#include "objects.h"

#define GRIP_LOAD_TIME_S 0.005 /* time constant of the load filter: a shock of one step does not open a grip */

typedef struct {
    double stiffness_Npm, damping_Nspm; /* 0 for a rigid grip */
    double force_limit_N;
    double torque_limit_Nm; /* for a fixed grip: limit of the torque about the grip point; 0: no limit */
} grip_properties_t;

typedef struct {
    grip_properties_t properties;
    dJointID joint; /* NULL if nothing is held */
    size_t object;
    grip_kind_t kind;
    dReal point_m[3]; /* grip point in the frame of the hand's body */
    dJointFeedback feedback;
    double load_N, load_Nm; /* smoothed load */
} grip_t;

/* Closes the grip on objects[object]. self must not move in memory while the grip is closed. point_m: grip point of the
 * hand. */
void grip_close(grip_t *self, dWorldID world, dBodyID hand, const scene_object_t objects[], size_t object,
                grip_kind_t kind, const double point_m[3]);
void grip_open(grip_t *self);

/* Sets ERP and CFM of the joint to the pads' stiffness and damping for a step of this length. Call it before the
 * step. */
void grip_prepare(grip_t *self, double step_s);

/* Returns true if the grip holds. If the load exceeds a limit, opens the grip and returns false. Call it after each
 * step. */
bool grip_hold(grip_t *self, double step_s);

/* Reads the force of the object on the hand. The force is zero if nothing is held. */
void grip_force_N(const grip_t *self, double force_N[3]);

#endif
