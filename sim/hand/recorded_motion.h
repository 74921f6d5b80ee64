/* A recording as a motion in torso axes: maps the recorder's axes, interpolates between samples and finds gaps. */
#ifndef COMANIP_SIM_RECORDED_MOTION_H
#define COMANIP_SIM_RECORDED_MOTION_H

#include <stdbool.h>
#include <stddef.h>

#include "../common/rigid_pose.h"

typedef struct recorded_motion recorded_motion_t;

/* Reads a CSV in the format of docs/recordings.md. axes: the recorder axes that correspond to the torso's x, y and z,
 * e.g. "xyz", "zxy" or "-yxz"; must be right-handed. If NULL, the file name decides (docs/recordings.md). Returns NULL
 * on failure; `error` then holds one line that names file, line, value and what was expected. */
recorded_motion_t *recorded_motion_create(const char *path, const char *axes, char error[], size_t error_size);

void recorded_motion_destroy(recorded_motion_t *self);

double recorded_motion_duration_s(const recorded_motion_t *self);

/* Sets pose to the hand's pose at time_s since the start of the recording, interpolated linearly in position and
 * spherically in rotation. Before the start, pose is the first recorded pose; after the end, it is the last. Returns
 * false in a gap (an interval above 1.5 times the median), where the interpolated pose is only a guess. */
bool recorded_motion_sample(const recorded_motion_t *self, double time_s, rigid_pose_t *pose);

/* Returns one line of text that describes the recording and how its axes are mapped. */
const char *recorded_motion_description(const recorded_motion_t *self);

#endif
