/* The physical scene in ODE: the robot's arm with gripper and cup, the people's hands, and the objects. ODE computes
 * all forces except those of the water. The scene's parts are in arm_plant.h, hand_body.h, grip.h, objects.h, support.h
 * and water.h. The drives, the gripper node and the people's programs command the scene.
 *
 * Arm, hands and objects form one system, which ODE's exact solver (dWorldStep) solves. The water is a second system:
 * the cups act on the water, but the water does not act on the cups. The same commands always produce bit-identical
 * results. */
#ifndef COMANIP_SIM_SCENE_H
#define COMANIP_SIM_SCENE_H

#include "../common/events.h"
#include "../scenario/scenario.h"
#include "arm_plant.h"
#include "water.h"

#define SCENE_HOLDER_ROBOT SCENARIO_MAX_PEOPLE /* a holder is a person's index, or this value */

typedef struct scene scene_t;

/* scenario and events must outlive the scene. The scene raises the events "robot.holds", "robot.lost" (slipped out),
 * "robot.opened", "robot.closed", "PERSON.holds", "PERSON.lost", "OBJECT.dropped" (held by nobody after it was held),
 * which the scenario declares. Returns NULL if out of memory, or if the particles of the water do not fit into the
 * robot's cup. Only one scene may exist at a time, because ODE's initialisation is global. */
scene_t *scene_create(const scenario_t *scenario, events_t *events);
void scene_destroy(scene_t *self);

/* Makes one physics step that begins at now_s. */
void scene_step(scene_t *self, double now_s, double step_s);

/* ---- robot */

arm_plant_t *scene_arm(const scene_t *self);
void scene_command_gripper(scene_t *self, bool close);
double scene_gripper_opening(const scene_t *self); /* 0 is closed, 1 is open; in between while an object is held */
bool scene_robot_holds(const scene_t *self);
double scene_gripper_force_N(const scene_t *self); /* force between gripper and object; 0 if nothing is held */
void scene_robot_cup(const scene_t *self, rigid_pose_t *cup);

/* ---- people */

/* Sets the desired pose of the hand at the end of the next step. The desired velocity is computed from the change since
 * the last call. Without external forces the hand reaches this pose exactly; forces deflect it against the arm's
 * stiffness. Call it before each scene_step(). */
void scene_aim_hand(scene_t *self, size_t person, const rigid_pose_t *hand);
void scene_hand(const scene_t *self, size_t person, rigid_pose_t *hand);

/* Closes the hand on the object. Returns false, and does nothing, if the hand already holds an object, if the object is
 * a stand, or if no part of the object's axis is within 25 mm of the grip point. */
bool scene_close_hand(scene_t *self, size_t person, size_t object);
void scene_open_hand(scene_t *self, size_t person);

/* Reads the force of the object on the hand in the last step, from ODE's joint. The force is zero if nothing is
 * held. */
void scene_hand_force_N(const scene_t *self, size_t person, double force_N[3]);

/* ---- objects */

void scene_object(const scene_t *self, size_t object, rigid_pose_t *pose);
bool scene_holds(const scene_t *self, size_t holder, size_t object);
double scene_crank_turns(const scene_t *self, size_t object); /* signed, since the start */

/* Computes the current position of a point. */
void scene_point(const scene_t *self, const point_t *point, double position_m[3]);

/* Counts the particles of the water by where they are now. All counts are zero if the scene has no water. */
water_count_t scene_water(const scene_t *self);

#endif
