/* Where the human's hand is at a time: a recording, or a built-in minimum-jerk motion. Poses are in torso axes. */
#ifndef COMANIP_SIM_HAND_MOTION_H
#define COMANIP_SIM_HAND_MOTION_H

#include <stdbool.h>
#include <stddef.h>

#include "../common/rigid_pose.h"

/* One leg of a built-in motion: minimum jerk from where the last one ended to this displacement from the start. */
typedef struct {
    double duration_s;             /* > 0 */
    double displacement_m[3];      /* torso axes, from the motion's start */
    double rotation_vector_rad[3]; /* torso axes, from the motion's start orientation */
} motion_leg_t;

typedef struct hand_motion hand_motion_t;

/* Starts at `start`, rests there until the first leg (a leg may also keep still). Copies the legs. Between the legs' end
 * orientations the rotation takes the shorter way. NULL: no memory. */
hand_motion_t *hand_motion_create_legs(const rigid_pose_t *start, const motion_leg_t legs[], size_t count);

/* Reads a CSV in the format of docs/recordings.md. axes: which recorder axes are the torso's x, y, z, e.g. "xyz", "zxy",
 * "-yxz"; must be right-handed; NULL chooses by the file's name (docs/recordings.md). On failure NULL, and `error` holds
 * one line that names file, line, value and what was expected. */
hand_motion_t *hand_motion_create_recording(const char *path, const char *axes, char error[], size_t error_size);

void hand_motion_destroy(hand_motion_t *self);

double hand_motion_duration_s(const hand_motion_t *self);

/* The hand at a time from the motion's start; before it, the first pose; after its end, the last. Linear in position,
 * spherical in rotation between samples. False: no pose there, for the time lies in a gap of the recording (an interval
 * above 1.5 times its median). */
bool hand_motion_sample(const hand_motion_t *self, double time_s, rigid_pose_t *pose);

/* One line for a person: what is played, and how axes were mapped. */
const char *hand_motion_description(const hand_motion_t *self);

#endif
