/* The arm as a rigid-body system in ODE: HOAP-3's right arm from robot_model.h, torso fixed to the world, gravity on,
 * hinges with mechanical stops and a velocity motor of limited torque each. No collisions. Exact solver
 * (dWorldStep): the same commands give the same bits. */
#ifndef COMANIP_SIM_ARM_PLANT_H
#define COMANIP_SIM_ARM_PLANT_H

#include "../hand/hand_motion.h"
#include "robot_model.h"

typedef struct arm_plant arm_plant_t;

/* At rest at start_rad, which lies within the stops; motors hold. One plant at a time: ODE's set-up is global. */
arm_plant_t *arm_plant_create(const double start_rad[ROBOT_JOINTS]);
void arm_plant_destroy(arm_plant_t *self);

/* What the joint's motor strives for, with up to ROBOT_TORQUE_PEAK_NM. 0 holds. */
void arm_plant_set_velocity(arm_plant_t *self, int joint, double velocity_radps);

void arm_plant_step(arm_plant_t *self, double step_s);

double arm_plant_position_rad(const arm_plant_t *self, int joint);
double arm_plant_velocity_radps(const arm_plant_t *self, int joint);

/* Torque about the joint's axis over the last step, from motor and stop together. */
double arm_plant_torque_Nm(const arm_plant_t *self, int joint);

/* The hand seen from the torso, from ODE's bodies alone; the quaternion's sign is continuous over time. */
void arm_plant_hand(const arm_plant_t *self, rigid_pose_t *hand);

#endif
