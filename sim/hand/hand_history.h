/* Recent poses of the tracked hand in the scene. The tracker samples them between ticks and reports them after its
 * latency. */
#ifndef COMANIP_SIM_HAND_HISTORY_H
#define COMANIP_SIM_HAND_HISTORY_H

#include <stdbool.h>
#include <stdint.h>

#include "../common/rigid_pose.h"

#define HAND_HISTORY_POSES 602 /* 0.6 s of 1 ms ticks, more than the tracker's largest latency, 0.5 s */

typedef struct hand_history hand_history_t;

/* Returns NULL if out of memory. */
hand_history_t *hand_history_create(void);
void hand_history_destroy(hand_history_t *self);

/* Adds the pose of a tick; times must increase. visible: whether the tracker can see the hand. */
void hand_history_push(hand_history_t *self, int64_t time_ns, const rigid_pose_t *pose, bool visible);

/* Sets pose to the hand's pose at time_ns, interpolated linearly in position and spherically in rotation, or
 * extrapolated by at most one tick beyond the newest pose. Returns false, leaving pose invalid, if time_ns is before
 * the oldest pose or if the hand was not visible in a pose used for the result. */
bool hand_history_sample(const hand_history_t *self, int64_t time_ns, rigid_pose_t *pose);

#endif
