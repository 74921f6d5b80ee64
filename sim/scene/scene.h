/* The physical scene in ODE: the robot's arm with gripper and cup, the people's hands, and what they handle. Forces are
 * ODE's, but the water's. Hands, grips, objects and water are its parts (hand_body.h, grip.h, objects.h, support.h,
 * water.h); who wants what is decided outside: by the drives (arm), the gripper node, the people's programs.
 *
 * Arm, hands and objects are one system for ODE's exact solver (dWorldStep); the water is a second one that feels the
 * cups and does not act on them. The same commands give the same bits. */
#ifndef COMANIP_SIM_SCENE_H
#define COMANIP_SIM_SCENE_H

#include "../common/events.h"
#include "../scenario/scenario.h"
#include "arm_plant.h"
#include "water.h"

#define SCENE_HOLDER_ROBOT SCENARIO_MAX_PEOPLE /* holders: a person's index, or this */

typedef struct scene scene_t;

/* scenario and events must outlive the scene. Raises "robot.holds", "robot.lost" (slipped out), "robot.opened",
 * "robot.closed", "PERSON.holds", "PERSON.lost", "OBJECT.dropped" (held by nobody, after it was held), declared in the
 * scenario's events. NULL: no memory. One scene at a time: ODE's set-up is global. */
scene_t *scene_create(const scenario_t *scenario, events_t *events);
void scene_destroy(scene_t *self);

/* One step of physics from now_s on. */
void scene_step(scene_t *self, double now_s, double step_s);

/* ---- robot */

arm_plant_t *scene_arm(const scene_t *self);
void scene_command_gripper(scene_t *self, bool close);
double scene_gripper_opening(const scene_t *self); /* 0 closed .. 1 open; stays ajar on a held object */
bool scene_robot_holds(const scene_t *self);
double scene_gripper_force_N(const scene_t *self); /* between gripper and object; 0: holds nothing */
void scene_robot_cup(const scene_t *self, rigid_pose_t *cup);

/* ---- people */

/* Where the person wants the hand to be at the end of the coming step, and how fast it then moves is the difference to
 * the last call. In the free the hand is exactly there; what pulls at it meets the arm's stiffness. Call before each
 * scene_step(). */
void scene_aim_hand(scene_t *self, size_t person, const rigid_pose_t *hand);
void scene_hand(const scene_t *self, size_t person, rigid_pose_t *hand);

/* False, and nothing happens, if the hand holds something already, if the object is a stand, or if no part of it is
 * within 25 mm of the grip. */
bool scene_close_hand(scene_t *self, size_t person, size_t object);
void scene_open_hand(scene_t *self, size_t person);

/* What the object does to the hand through ODE's joint, over the last step; zero: holds nothing. */
void scene_hand_force_N(const scene_t *self, size_t person, double force_N[3]);

/* ---- objects */

void scene_object(const scene_t *self, size_t object, rigid_pose_t *pose);
bool scene_holds(const scene_t *self, size_t holder, size_t object);
double scene_crank_turns(const scene_t *self, size_t object); /* signed, since the start */

/* A point as it is now. */
void scene_point(const scene_t *self, const point_t *point, double position_m[3]);

/* The water as it is now; all zero: there is none. */
water_count_t scene_water(const scene_t *self);

#endif
