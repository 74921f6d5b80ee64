/* Plays a section of a recording. The hand repeats the recorded motion, starting from the pose at which the playback
 * begins. */
#ifndef COMANIP_SIM_PLAYBACK_H
#define COMANIP_SIM_PLAYBACK_H

#include "recorded_motion.h"

typedef struct {
    const recorded_motion_t *motion;
    double from_s, until_s; /* section of the recording */
    double position_scale, rotation_scale;
    double begin_s;
    rigid_pose_t here;  /* pose of the hand at begin_s */
    rigid_pose_t first; /* pose of the recording at from_s */
} playback_t;

/* `motion` must outlive self. If until_s is 0, the recording is played to its end. */
void playback_init(playback_t *self, const recorded_motion_t *motion, double from_s, double until_s,
                   double position_scale, double rotation_scale);

void playback_begin(playback_t *self, double begin_s, const rigid_pose_t *here);

double playback_duration_s(const playback_t *self);

/* Sets pose to the hand's pose at time_s: `here`, moved by the recorded displacement since from_s times position_scale,
 * and turned by the recorded rotation vector since from_s times rotation_scale, both in torso axes. Handles rotations
 * of up to a full turn. Returns false in a gap of the recording. */
bool playback_sample(const playback_t *self, double time_s, rigid_pose_t *pose);

#endif
