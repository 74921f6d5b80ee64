/* Executes the steps of a person's program by setting the desired pose of their hand in the scene, including tremor. A
 * person sees the positions of objects, hands and gripper, corrects errors with short moves, and waits for events. */
#ifndef COMANIP_SIM_PERSON_PROGRAM_H
#define COMANIP_SIM_PERSON_PROGRAM_H

#include "../scene/scene.h"

typedef struct person_program person_program_t;

/* scenario, scene and events must outlive the program. recording: path from the command line, or NULL. If a path
 * is given, the steps of program_with_recording are executed instead of those of program. Returns NULL on failure, for
 * example if a recording cannot be read, with one line in `error`. */
person_program_t *person_program_create(const scenario_t *scenario, size_t person, scene_t *scene, events_t *events,
                                        const char *recording, const char *axes, uint64_t seed, char error[],
                                        size_t error_size);
void person_program_destroy(person_program_t *self);

/* Sets the desired hand pose for the simulation step that ends at until_s. robot_gain: displacement of the end effector
 * per displacement of this hand, for each axis. With s = parameter motion_scale, it is (s, s, s), or (-s, s, s) while
 * the task mirrors. A person who guides the robot is assumed to know this gain. */
void person_program_step(person_program_t *self, double now_s, double until_s, const double robot_gain[3]);

bool person_program_is_done(const person_program_t *self);

/* Returns true while the hand replays a recording. */
bool person_program_plays(const person_program_t *self);

/* Returns the desired pose of the hand, without tremor. */
rigid_pose_t person_program_aim(const person_program_t *self);

/* Returns true during a gap in a recording, when the tracker cannot see the hand. */
bool person_program_is_hidden(const person_program_t *self);

/* Describes the current step: "ann waits for robot.holds", "ann is at step 9 of 20", "ann is done". */
void person_program_describe(const person_program_t *self, char text[], size_t size);

/* Returns one line that names the person and what failed or timed out, or NULL if nothing did. */
const char *person_program_failure(const person_program_t *self);

/* Returns one line about the recording that is played (file, samples, gaps, scale), or "" if there is none. */
const char *person_program_description(const person_program_t *self);

#endif
