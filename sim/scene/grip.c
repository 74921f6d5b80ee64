#include "grip.h"

#include <math.h>
#include <string.h>

static void set_parameter(const grip_t *self, int parameter, double value) {
    if (self->kind == GRIP_BALL) {
        dJointSetBallParam(self->joint, parameter, value);
    } else {
        dJointSetFixedParam(self->joint, parameter, value);
    }
}

void grip_close(grip_t *self, dWorldID world, dBodyID hand, const scene_object_t objects[], size_t object,
                grip_kind_t kind, const double point_m[3]) {
    double anchor[3];
    (void)scene_object_nearest(&objects[object], point_m, anchor);
    self->object = object;
    self->kind = kind;
    self->load_N = self->load_Nm = 0.0;
    memset(&self->feedback, 0, sizeof self->feedback);
    if (kind == GRIP_BALL) {
        self->joint = dJointCreateBall(world, NULL);
        dJointAttach(self->joint, hand, objects[object].body);
        dJointSetBallAnchor(self->joint, anchor[0], anchor[1], anchor[2]);
    } else {
        self->joint = dJointCreateFixed(world, NULL);
        dJointAttach(self->joint, hand, objects[object].body);
        dJointSetFixed(self->joint);
    }
    dVector3 point;
    dBodyGetPosRelPoint(hand, anchor[0], anchor[1], anchor[2], point);
    memcpy(self->point_m, point, sizeof self->point_m);
    dJointSetFeedback(self->joint, &self->feedback);
}

void grip_open(grip_t *self) {
    if (self->joint != NULL) {
        dJointDestroy(self->joint);
        self->joint = NULL;
        memset(&self->feedback, 0, sizeof self->feedback);
    }
}

void grip_prepare(grip_t *self, double step_s) {
    const grip_properties_t *p = &self->properties;
    if (self->joint != NULL && p->stiffness_Npm > 0.0) {
        const double total = step_s * p->stiffness_Npm + p->damping_Nspm;
        set_parameter(self, dParamERP, step_s * p->stiffness_Npm / total);
        set_parameter(self, dParamCFM, 1.0 / total);
    }
}

static double length(const dReal v[3]) {
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* Returns the torque at the grip. ODE reports the torque at the centre of mass of the hand's body. */
static double torque_at_grip_Nm(const grip_t *self) {
    const dReal *f = self->feedback.f1, *t = self->feedback.t1;
    dVector3 r;
    dBodyVectorToWorld(dJointGetBody(self->joint, 0), self->point_m[0], self->point_m[1], self->point_m[2], r);
    const dReal torque_Nm[3] = {t[0] - (r[1] * f[2] - r[2] * f[1]), t[1] - (r[2] * f[0] - r[0] * f[2]),
                                t[2] - (r[0] * f[1] - r[1] * f[0])};
    return length(torque_Nm);
}

bool grip_hold(grip_t *self, double step_s) {
    if (self->joint == NULL) {
        return true;
    }
    const double share = step_s / (GRIP_LOAD_TIME_S + step_s);
    self->load_N += share * (length(self->feedback.f1) - self->load_N);
    self->load_Nm += share * (torque_at_grip_Nm(self) - self->load_Nm);
    const double limit_Nm = self->kind == GRIP_FIXED ? self->properties.torque_limit_Nm : 0.0;
    if (self->load_N <= self->properties.force_limit_N && (limit_Nm <= 0.0 || self->load_Nm <= limit_Nm)) {
        return true;
    }
    grip_open(self);
    return false;
}

void grip_force_N(const grip_t *self, double force_N[3]) {
    for (int k = 0; k < 3; k++) {
        force_N[k] = self->joint != NULL ? self->feedback.f1[k] : 0.0;
    }
}
