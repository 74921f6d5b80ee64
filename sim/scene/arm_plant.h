/* The arm as a rigid-body system in ODE: HOAP-3's right arm from robot_model.h, torso fixed to the world, hinges with
 * mechanical stops and a velocity motor of limited torque each. No collisions. The world and its steps are the scene's.
 */
#ifndef COMANIP_SIM_ARM_PLANT_H
#define COMANIP_SIM_ARM_PLANT_H

#include "../common/rigid_pose.h"
#include "../robot/robot_model.h"

struct dxBody;
struct dxWorld;

typedef struct arm_plant arm_plant_t;

/* At rest at start_rad, which lies within the stops; motors hold. The bodies go with the world. NULL: no memory. */
arm_plant_t *arm_plant_create(struct dxWorld *world, const double start_rad[ROBOT_JOINTS]);
void arm_plant_destroy(arm_plant_t *self);

/* What the joint's motor strives for, with up to ROBOT_TORQUE_PEAK_NM. 0 holds. */
void arm_plant_set_velocity(arm_plant_t *self, int joint, double velocity_radps);

/* Takes the motor's torque away: the joint swings freely between its stops. */
void arm_plant_release(arm_plant_t *self, int joint);

double arm_plant_position_rad(const arm_plant_t *self, int joint);
double arm_plant_velocity_radps(const arm_plant_t *self, int joint);

/* Torque about the joint's axis over the last step, from motor and stop together. */
double arm_plant_torque_Nm(const arm_plant_t *self, int joint);

/* The hand seen from the torso, from ODE's bodies alone; the quaternion's sign is continuous over time. */
void arm_plant_hand(const arm_plant_t *self, rigid_pose_t *hand);

/* The body that a grip is fixed to: the forearm with the hand. */
struct dxBody *arm_plant_hand_body(const arm_plant_t *self);

#endif
