/* A hold on an object that slips beyond a load: ODE's ball or fixed joint between a hand and the object, at the point
 * of the object's axis nearest to the hand. A robot's pads give way like springs (ERP and CFM of ODE's joint: implicit,
 * so stable for any stiffness; a fixed grip turns with the hand rigidly), a person's compliance is the arm's
 * (hand_body.h). */
#ifndef COMANIP_SIM_GRIP_H
#define COMANIP_SIM_GRIP_H

#include <ode/ode.h>
#include <stdbool.h>

#include "objects.h"

#define GRIP_LOAD_TIME_S 0.005 /* the load is smoothed over so long: one step's shock does not open a hand */

typedef struct {
    double stiffness_Npm, damping_Nspm; /* 0: rigid */
    double force_limit_N;
    double torque_limit_Nm; /* about the grip, of a fixed one; 0: none */
} grip_properties_t;

typedef struct {
    grip_properties_t properties;
    dJointID joint; /* NULL: holds nothing */
    size_t object;
    grip_kind_t kind;
    dReal point_m[3]; /* of the grip, in the frame of the hand's body */
    dJointFeedback feedback;
    double load_N, load_Nm; /* smoothed */
} grip_t;

/* The grip must stay where it is in memory while it holds. point_m: of the hand. */
void grip_close(grip_t *self, dWorldID world, dBodyID hand, const scene_object_t objects[], size_t object,
                grip_kind_t kind, const double point_m[3]);
void grip_open(grip_t *self);

/* Before a step: the pads' stiffness for this step's length. */
void grip_prepare(grip_t *self, double step_s);

/* After a step. False: the load was too much, and the grip is open now. */
bool grip_hold(grip_t *self, double step_s);

/* What the object does to the hand; zero: holds nothing. */
void grip_force_N(const grip_t *self, double force_N[3]);

#endif
