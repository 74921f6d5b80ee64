/* Where the hand of the scene has been of late: the tracker measures it between ticks and tells it later. */
#ifndef COMANIP_SIM_HAND_HISTORY_H
#define COMANIP_SIM_HAND_HISTORY_H

#include <stdbool.h>
#include <stdint.h>

#include "../common/rigid_pose.h"

#define HAND_HISTORY_POSES 602 /* 0.6 s of ticks of 1 ms: the tracker's largest latency, and some */

typedef struct hand_history hand_history_t;

/* NULL: no memory. */
hand_history_t *hand_history_create(void);
void hand_history_destroy(hand_history_t *self);

/* Times must increase: one pose per tick. visible: the tracker could see it. */
void hand_history_push(hand_history_t *self, int64_t time_ns, const rigid_pose_t *pose, bool visible);

/* Linear in position, spherical in rotation between the poses. Beyond the newest it goes on as between the last two,
 * for one more tick at most. False, and no pose: before the oldest, or where a neighbour was not visible. */
bool hand_history_sample(const hand_history_t *self, int64_t time_ns, rigid_pose_t *pose);

#endif
