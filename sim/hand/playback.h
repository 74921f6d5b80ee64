/* A part of a recording played from where the hand is: what the recorded hand did since, the hand does too. */
#ifndef COMANIP_SIM_PLAYBACK_H
#define COMANIP_SIM_PLAYBACK_H

#include "recorded_motion.h"

typedef struct {
    const recorded_motion_t *motion;
    double from_s, until_s; /* of the recording */
    double position_scale, rotation_scale;
    double begin_s;
    rigid_pose_t here;  /* of the hand at the begin */
    rigid_pose_t first; /* of the recording at from_s */
} playback_t;

/* The motion must outlive it. until_s 0: to its end. */
void playback_init(playback_t *self, const recorded_motion_t *motion, double from_s, double until_s,
                   double position_scale, double rotation_scale);

void playback_begin(playback_t *self, double begin_s, const rigid_pose_t *here);

double playback_duration_s(const playback_t *self);

/* The displacement since from_s times position_scale, the rotation vector since then times rotation_scale, both in
 * torso axes, applied to `here`. A rotation is followed up to a whole turn. False: in a gap of the recording. */
bool playback_sample(const playback_t *self, double time_s, rigid_pose_t *pose);

#endif
