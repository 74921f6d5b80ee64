#include "arm_plant.h"

#include <ode/ode.h>
#include <stdlib.h>

#include "../common/rigid_pose.h"

struct arm_plant {
    dWorldID world;
    dBodyID body[ROBOT_JOINTS];
    dJointID hinge[ROBOT_JOINTS];
    dJointFeedback feedback[ROBOT_JOINTS];
};

/* Places each body at its link frame. ODE's body origin is the centre of mass; its axes are those of the link frame. */
static void place_bodies(arm_plant_t *self, const double position_rad[ROBOT_JOINTS]) {
    transform_t link[ROBOT_JOINTS], hand;
    robot_model_forward(position_rad, link, &hand);
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        const double *r = link[i].rotation;
        const double *c = robot_joint_table[i].centre_m;
        const double *p = link[i].position_m;
        const dMatrix3 rotation = {r[0], r[1], r[2], 0.0, r[3], r[4], r[5], 0.0, r[6], r[7], r[8], 0.0};
        dBodySetRotation(self->body[i], rotation);
        dBodySetPosition(self->body[i], p[0] + r[0] * c[0] + r[1] * c[1] + r[2] * c[2],
                         p[1] + r[3] * c[0] + r[4] * c[1] + r[5] * c[2],
                         p[2] + r[6] * c[0] + r[7] * c[1] + r[8] * c[2]);
    }
}

static void set_mass(dBodyID body, const robot_joint_t *joint) {
    const int axis_y = 2, axis_z = 3; /* dMassSetCylinderTotal numbers the axes x, y, z from 1 */
    dMass mass;
    if (joint->shape == LINK_BOX) {
        dMassSetBoxTotal(&mass, joint->mass_kg, joint->length_m, joint->length_m, joint->length_m);
    } else {
        dMassSetCylinderTotal(&mass, joint->mass_kg, joint->shape == LINK_ROD_Y ? axis_y : axis_z, joint->radius_m,
                              joint->length_m);
    }
    dBodySetMass(body, &mass);
}

/* Connects the bodies by hinges. First places the bodies at joint angles of 0, because ODE measures the angle of a
 * hinge from the pose in which the hinge was created. */
static void create_hinges(arm_plant_t *self) {
    const double zero_rad[ROBOT_JOINTS] = {0.0};
    transform_t link[ROBOT_JOINTS], hand;
    place_bodies(self, zero_rad);
    robot_model_forward(zero_rad, link, &hand);
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        const dBodyID parent = i == 0 ? NULL : self->body[i - 1]; /* NULL is the torso, which is fixed to the world */
        const dJointID hinge = dJointCreateHinge(self->world, NULL);
        dJointAttach(hinge, self->body[i], parent);
        dJointSetHingeAnchor(hinge, link[i].position_m[0], link[i].position_m[1], link[i].position_m[2]);
        dJointSetHingeAxis(hinge, link[i].rotation[2], link[i].rotation[5], link[i].rotation[8]);
        dJointSetHingeParam(hinge, dParamLoStop, robot_joint_table[i].stop_min_rad);
        dJointSetHingeParam(hinge, dParamHiStop, robot_joint_table[i].stop_max_rad);
        dJointSetHingeParam(hinge, dParamFMax, ROBOT_TORQUE_PEAK_NM);
        dJointSetFeedback(hinge, &self->feedback[i]);
        self->hinge[i] = hinge;
    }
}

arm_plant_t *arm_plant_create(dWorldID world, const double start_rad[ROBOT_JOINTS]) {
    arm_plant_t *self = calloc(1, sizeof *self);
    if (self == NULL) {
        return NULL;
    }
    self->world = world;
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        self->body[i] = dBodyCreate(self->world);
        set_mass(self->body[i], &robot_joint_table[i]);
    }
    create_hinges(self);
    place_bodies(self, start_rad);
    return self;
}

void arm_plant_destroy(arm_plant_t *self) {
    free(self);
}

void arm_plant_set_velocity(arm_plant_t *self, int joint, double velocity_radps) {
    dJointSetHingeParam(self->hinge[joint], dParamVel, velocity_radps);
}

void arm_plant_release(arm_plant_t *self, int joint) {
    dJointSetHingeParam(self->hinge[joint], dParamFMax, 0.0);
}

double arm_plant_position_rad(const arm_plant_t *self, int joint) {
    return dJointGetHingeAngle(self->hinge[joint]);
}

double arm_plant_velocity_radps(const arm_plant_t *self, int joint) {
    return dJointGetHingeAngleRate(self->hinge[joint]);
}

double arm_plant_torque_Nm(const arm_plant_t *self, int joint) {
    /* ODE reports force and torque at the body's centre of mass. Transform the torque to the hinge's anchor. */
    const dReal *f = self->feedback[joint].f1;
    const dReal *t = self->feedback[joint].t1;
    const dReal *centre = dBodyGetPosition(self->body[joint]);
    dVector3 anchor, axis;
    dJointGetHingeAnchor(self->hinge[joint], anchor);
    dJointGetHingeAxis(self->hinge[joint], axis);
    const double r[3] = {anchor[0] - centre[0], anchor[1] - centre[1], anchor[2] - centre[2]};
    return axis[0] * (t[0] - (r[1] * f[2] - r[2] * f[1])) + axis[1] * (t[1] - (r[2] * f[0] - r[0] * f[2])) +
           axis[2] * (t[2] - (r[0] * f[1] - r[1] * f[0]));
}

void arm_plant_hand(const arm_plant_t *self, rigid_pose_t *hand) {
    const dBodyID forearm = self->body[ROBOT_JOINTS - 1];
    const double *centre = robot_joint_table[ROBOT_JOINTS - 1].centre_m;
    dVector3 position;
    dBodyGetRelPointPos(forearm, robot_hand_offset_m[0] - centre[0], robot_hand_offset_m[1] - centre[1],
                        robot_hand_offset_m[2] - centre[2], position);
    for (int i = 0; i < 3; i++) {
        hand->position_m[i] = position[i];
    }
    rotation_multiply(dBodyGetQuaternion(forearm), robot_hand_rotation, hand->rotation);
}

dBodyID arm_plant_hand_body(const arm_plant_t *self) {
    return self->body[ROBOT_JOINTS - 1];
}
