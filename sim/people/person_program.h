/* What a person wants: plays the steps of a person's program and aims the hand in the scene accordingly, with tremor. A
 * person sees where objects, hands and gripper are, corrects in short moves, and waits for events. */
#ifndef COMANIP_SIM_PERSON_PROGRAM_H
#define COMANIP_SIM_PERSON_PROGRAM_H

#include "../scene/scene.h"

typedef struct person_program person_program_t;

/* scenario, scene and events must outlive the program. recording: NULL, or the path that the command line gives: then
 * the recorded steps are played. On failure NULL, and one line in `error` (a recording that cannot be read, ...). */
person_program_t *person_program_create(const scenario_t *scenario, size_t person, scene_t *scene, events_t *events,
                                        const char *recording, const char *axes, uint64_t seed, char error[],
                                        size_t error_size);
void person_program_destroy(person_program_t *self);

/* Aims the hand for the step that ends at until_s. robot_follows: how a displacement of this hand moves the robot's,
 * per axis: (scale, scale, scale), or (-scale, scale, scale) while it mirrors; a guiding person has learned it. */
void person_program_step(person_program_t *self, double now_s, double until_s, const double robot_follows[3]);

bool person_program_is_done(const person_program_t *self);

/* The hand does what a recording says. */
bool person_program_plays(const person_program_t *self);

/* Where it wants the hand, without tremor. */
rigid_pose_t person_program_aim(const person_program_t *self);

/* The hand is where a recording lost it: the tracker does not see it. */
bool person_program_is_hidden(const person_program_t *self);

/* What the person is about: "ann waits for robot.holds", "ann is at step 9 of 20", "ann is done". */
void person_program_describe(const person_program_t *self, char text[], size_t size);

/* NULL, or one line: who could not do what, or waited in vain for what. */
const char *person_program_failure(const person_program_t *self);

/* One line for a person about the recording that is played: file, samples, gaps, scale. "": none. */
const char *person_program_description(const person_program_t *self);

#endif
