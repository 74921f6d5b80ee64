/* A grip on an object that slips above a load limit: a ball or fixed joint of ODE between a hand and the object, at the
 * point of the object's axis nearest to the hand. The robot's pads act as springs (ERP and CFM of ODE's joint:
 * implicit, so stable for any stiffness; a fixed grip rotates rigidly with the hand). A person's compliance is that of
 * the arm (hand_body.h). */
#ifndef COMANIP_SIM_GRIP_H
#define COMANIP_SIM_GRIP_H

#include <ode/ode.h>
#include <stdbool.h>

#include "objects.h"

#define GRIP_LOAD_TIME_S 0.005 /* time constant of the load: a shock of one step does not open a hand */

typedef struct {
    double stiffness_Npm, damping_Nspm; /* 0: rigid */
    double force_limit_N;
    double torque_limit_Nm; /* about the grip, for a fixed grip; 0: none */
} grip_properties_t;

typedef struct {
    grip_properties_t properties;
    dJointID joint; /* NULL: nothing is held */
    size_t object;
    grip_kind_t kind;
    dReal point_m[3]; /* grip point in the frame of the hand's body */
    dJointFeedback feedback;
    double load_N, load_Nm; /* smoothed */
} grip_t;

/* self must keep its address while the grip is closed. point_m: grip point of the hand. */
void grip_close(grip_t *self, dWorldID world, dBodyID hand, const scene_object_t objects[], size_t object,
                grip_kind_t kind, const double point_m[3]);
void grip_open(grip_t *self);

/* Called before a step: sets the pads' stiffness for the length of this step. */
void grip_prepare(grip_t *self, double step_s);

/* Called after a step. Returns false if the load exceeded its limit; the grip is then open. */
bool grip_hold(grip_t *self, double step_s);

/* Force of the object on the hand; zero if nothing is held. */
void grip_force_N(const grip_t *self, double force_N[3]);

#endif
