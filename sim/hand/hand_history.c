#include "hand_history.h"

#include <assert.h>
#include <stddef.h>
#include <stdlib.h>

typedef struct {
    int64_t time_ns;
    rigid_pose_t pose; /* its quaternion is the one of q and -q that is closer to the previous entry's */
    bool visible;
} entry_t;

struct hand_history {
    entry_t ring[HAND_HISTORY_POSES];
    size_t first; /* index of the oldest entry */
    size_t count;
};

hand_history_t *hand_history_create(void) {
    return calloc(1, sizeof(hand_history_t));
}

void hand_history_destroy(hand_history_t *self) {
    free(self);
}

static const entry_t *entry(const hand_history_t *self, size_t age_order) {
    return &self->ring[(self->first + age_order) % HAND_HISTORY_POSES];
}

void hand_history_push(hand_history_t *self, int64_t time_ns, const rigid_pose_t *pose, bool visible) {
    entry_t new = {.time_ns = time_ns, .pose = *pose, .visible = visible};
    if (self->count > 0) {
        const entry_t *newest = entry(self, self->count - 1);
        assert(time_ns > newest->time_ns);
        rigid_pose_choose_side(&new.pose, &newest->pose);
    }
    self->ring[(self->first + self->count) % HAND_HISTORY_POSES] = new;
    if (self->count < HAND_HISTORY_POSES) {
        self->count++;
    } else {
        self->first = (self->first + 1) % HAND_HISTORY_POSES;
    }
}

/* Returns the index of the last entry at or before time_ns, but never that of the newest entry, which has no
 * successor. */
static size_t find_before(const hand_history_t *self, int64_t time_ns) {
    size_t from = 0;
    size_t to = self->count - 1;
    while (to - from > 1) {
        const size_t middle = from + (to - from) / 2;
        if (entry(self, middle)->time_ns <= time_ns) {
            from = middle;
        } else {
            to = middle;
        }
    }
    return from;
}

bool hand_history_sample(const hand_history_t *self, int64_t time_ns, rigid_pose_t *pose) {
    if (self->count == 0 || time_ns < entry(self, 0)->time_ns) {
        return false;
    }
    const size_t index = self->count == 1 ? 0 : find_before(self, time_ns);
    const entry_t *from = entry(self, index);
    if (self->count == 1 || time_ns == from->time_ns) {
        *pose = from->pose;
        return from->visible;
    }
    const entry_t *to = entry(self, index + 1);
    if (time_ns == to->time_ns) {
        *pose = to->pose;
        return to->visible;
    }
    const double fraction = (double)(time_ns - from->time_ns) / (double)(to->time_ns - from->time_ns);
    rigid_pose_interpolate(&from->pose, &to->pose, fraction < 2.0 ? fraction : 2.0, pose);
    return from->visible && to->visible;
}
