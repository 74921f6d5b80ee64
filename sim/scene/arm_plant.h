/* The arm as a rigid-body system in ODE: the right arm of the HOAP-3 (robot_model.h), with the torso fixed to the
 * world. Each hinge has mechanical stops and a velocity motor of limited torque. The arm does not collide with
 * anything. The scene owns the ODE world and steps it. */
#ifndef COMANIP_SIM_ARM_PLANT_H
#define COMANIP_SIM_ARM_PLANT_H

#include "../common/rigid_pose.h"
#include "../robot/robot_model.h"

struct dxBody;
struct dxWorld;

typedef struct arm_plant arm_plant_t;

/* Creates the arm at rest at start_rad, which must lie within the stops. The motors hold the arm there. The bodies are
 * destroyed with the world. Returns NULL if out of memory. */
arm_plant_t *arm_plant_create(struct dxWorld *world, const double start_rad[ROBOT_JOINTS]);
void arm_plant_destroy(arm_plant_t *self);

/* Sets the setpoint of the joint's motor, whose torque is at most ROBOT_TORQUE_PEAK_NM. A setpoint of 0 holds the
 * joint. */
void arm_plant_set_velocity(arm_plant_t *self, int joint, double velocity_radps);

/* Sets the motor's torque to zero, so that the joint swings freely between its stops. */
void arm_plant_release(arm_plant_t *self, int joint);

double arm_plant_position_rad(const arm_plant_t *self, int joint);
double arm_plant_velocity_radps(const arm_plant_t *self, int joint);

/* Returns the combined torque of motor and stop about the joint's axis during the last step. */
double arm_plant_torque_Nm(const arm_plant_t *self, int joint);

/* Computes the pose of the end effector in the torso frame from ODE's bodies. The quaternion's sign is continuous over
 * time. */
void arm_plant_hand(const arm_plant_t *self, rigid_pose_t *hand);

/* Returns the body that a grip is attached to, which is the forearm with the end effector. */
struct dxBody *arm_plant_hand_body(const arm_plant_t *self);

#endif
