/* A recording as a motion in torso axes: sampled at any time, its axes mapped, its gaps known. */
#ifndef COMANIP_SIM_RECORDED_MOTION_H
#define COMANIP_SIM_RECORDED_MOTION_H

#include <stdbool.h>
#include <stddef.h>

#include "../common/rigid_pose.h"

typedef struct recorded_motion recorded_motion_t;

/* Reads a CSV in the format of docs/recordings.md. axes: which recorder axes are the torso's x, y, z, e.g. "xyz",
 * "zxy",
 * "-yxz"; must be right-handed; NULL chooses by the file's name (docs/recordings.md). On failure NULL, and `error`
 * holds one line that names file, line, value and what was expected. */
recorded_motion_t *recorded_motion_create(const char *path, const char *axes, char error[], size_t error_size);

void recorded_motion_destroy(recorded_motion_t *self);

double recorded_motion_duration_s(const recorded_motion_t *self);

/* The hand at a time from the recording's start; before it, the first pose; after its end, the last. Linear in
 * position, spherical in rotation between samples. False: the time lies in a gap (an interval above 1.5 times the
 * median), and the pose is a guess between its ends. */
bool recorded_motion_sample(const recorded_motion_t *self, double time_s, rigid_pose_t *pose);

/* One line for a person: what is played, and how axes were mapped. */
const char *recorded_motion_description(const recorded_motion_t *self);

#endif
