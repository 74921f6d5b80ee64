#include "objects.h"

#include <math.h>
#include <ode/ode.h>
#include <string.h>

#define ROD_SPIN_TIME_S 0.025 /* damping time constant of a rod's spin about its axis, which ball grips leave free */
#define AXIS_Z 3              /* dMassSetCylinderTotal numbers the axes x, y, z from 1 */

/* Returns the pose of the centre of the handle, which is the only body of a crank. */
static rigid_pose_t crank_handle(const object_t *data) {
    const rigid_pose_t offset = {{data->radius_m, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}};
    return rigid_pose_multiply(&data->pose, &offset);
}

static void create_body(scene_object_t *self, dWorldID world, const rigid_pose_t *pose, double radius_m) {
    dMass mass;
    dMassSetCylinderTotal(&mass, self->data->mass_kg, AXIS_Z, radius_m, self->data->length_m);
    self->body = dBodyCreate(world);
    dBodySetMass(self->body, &mass);
    dBodySetPosition(self->body, pose->position_m[0], pose->position_m[1], pose->position_m[2]);
    dBodySetQuaternion(self->body, pose->rotation);
}

static void create_hinge(scene_object_t *self, dWorldID world) {
    const object_t *data = self->data;
    const double z[3] = {0.0, 0.0, 1.0};
    double axis[3];
    rotation_apply(data->pose.rotation, z, axis);
    self->hinge = dJointCreateHinge(world, NULL);
    dJointAttach(self->hinge, self->body, NULL);
    dJointSetHingeAnchor(self->hinge, data->pose.position_m[0], data->pose.position_m[1], data->pose.position_m[2]);
    dJointSetHingeAxis(self->hinge, axis[0], axis[1], axis[2]);
    dJointSetHingeParam(self->hinge, dParamVel, 0.0); /* a motor with setpoint 0 acts as dry friction */
    dJointSetHingeParam(self->hinge, dParamFMax, data->friction_Nm);
}

/* Adds viscous friction to the hinge, as a motor with setpoint 0 and a compliance of 1/damping. Such a motor is stable
 * for any step length. */
static void create_damper(const scene_object_t *self, dWorldID world) {
    dVector3 axis;
    dJointGetHingeAxis(self->hinge, axis);
    const dJointID damper = dJointCreateAMotor(world, NULL);
    dJointAttach(damper, self->body, NULL);
    dJointSetAMotorNumAxes(damper, 1);
    dJointSetAMotorAxis(damper, 0, 0, axis[0], axis[1], axis[2]);
    dJointSetAMotorParam(damper, dParamVel, 0.0);
    dJointSetAMotorParam(damper, dParamFMax, dInfinity);
    dJointSetAMotorParam(damper, dParamCFM, 1.0 / self->data->damping_Nmspprad);
}

void scene_object_init(scene_object_t *self, dWorldID world, const object_t *data) {
    memset(self, 0, sizeof *self);
    self->data = data;
    if (data->kind == OBJECT_ROD) {
        create_body(self, world, &data->pose, data->radius_m);
    } else if (data->kind == OBJECT_CRANK) {
        const rigid_pose_t handle = crank_handle(data);
        create_body(self, world, &handle, OBJECT_HANDLE_RADIUS_M);
        create_hinge(self, world);
        if (data->damping_Nmspprad > 0.0) {
            create_damper(self, world);
        }
    }
}

static void count_turns(scene_object_t *self) {
    const double angle_rad = dJointGetHingeAngle(self->hinge);
    self->hinge_angle_rad += remainder(angle_rad - self->last_angle_rad, 2.0 * ROBOT_PI);
    self->last_angle_rad = angle_rad;
}

static void damp_spin(scene_object_t *self) {
    const dReal *matrix = dBodyGetRotation(self->body);
    const dReal *spin = dBodyGetAngularVel(self->body);
    const double axis[3] = {matrix[2], matrix[6], matrix[10]};
    const double rate = spin[0] * axis[0] + spin[1] * axis[1] + spin[2] * axis[2];
    const double inertia_kgm2 = 0.5 * self->data->mass_kg * self->data->radius_m * self->data->radius_m;
    const double torque_Nm = -inertia_kgm2 * rate / ROD_SPIN_TIME_S;
    dBodyAddTorque(self->body, torque_Nm * axis[0], torque_Nm * axis[1], torque_Nm * axis[2]);
}

void scene_object_prepare(scene_object_t *self) {
    if (self->data->kind == OBJECT_CRANK) {
        count_turns(self);
    } else if (self->data->kind == OBJECT_ROD) {
        damp_spin(self);
    }
}

static void body_pose(dBodyID body, rigid_pose_t *pose) {
    memcpy(pose->position_m, dBodyGetPosition(body), sizeof pose->position_m);
    memcpy(pose->rotation, dBodyGetQuaternion(body), sizeof pose->rotation);
}

void scene_object_pose(const scene_object_t *self, rigid_pose_t *pose) {
    if (self->data->kind == OBJECT_STAND) {
        *pose = self->data->pose;
    } else {
        body_pose(self->body, pose);
        if (self->data->kind == OBJECT_CRANK) {
            memcpy(pose->position_m, self->data->pose.position_m, sizeof pose->position_m);
        }
    }
}

void scene_object_point(const scene_object_t *self, double along_m, double position_m[3]) {
    rigid_pose_t axis = self->data->pose;
    if (self->body != NULL) {
        body_pose(self->body, &axis);
    }
    const double along[3] = {0.0, 0.0, along_m};
    rotation_apply(axis.rotation, along, position_m);
    for (int k = 0; k < 3; k++) {
        position_m[k] += axis.position_m[k];
    }
}

double scene_object_nearest(const scene_object_t *self, const double position_m[3], double nearest_m[3]) {
    double centre[3], end[3];
    const double half_m = 0.5 * self->data->length_m;
    scene_object_point(self, 0.0, centre);
    scene_object_point(self, half_m, end);
    double along_m = 0.0;
    for (int k = 0; k < 3; k++) {
        along_m += (position_m[k] - centre[k]) * (end[k] - centre[k]) / half_m;
    }
    scene_object_point(self, fmax(-half_m, fmin(half_m, along_m)), nearest_m);
    return sqrt(pow(position_m[0] - nearest_m[0], 2) + pow(position_m[1] - nearest_m[1], 2) +
                pow(position_m[2] - nearest_m[2], 2));
}
