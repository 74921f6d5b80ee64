#include "hand_path.h"

#include <stddef.h>

#include "minimum_jerk.h"

void hand_path_init(hand_path_t *self, const rigid_pose_t *from, const rigid_pose_t *to, const double bow_m[3],
                    double begin_s, double duration_s) {
    *self = (hand_path_t){.from = *from, .to = *to, .begin_s = begin_s, .duration_s = duration_s};
    rigid_pose_choose_side(&self->to, from);
    for (int i = 0; i < 3 && bow_m != NULL; i++) {
        self->bow_m[i] = bow_m[i];
    }
}

void hand_path_sample(const hand_path_t *self, double time_s, rigid_pose_t *pose) {
    const double since_s = time_s - self->begin_s;
    if (since_s >= self->duration_s) {
        *pose = self->to;
        return;
    }
    const double share = minimum_jerk_share(since_s / self->duration_s);
    const double bow = 16.0 * share * share * (1.0 - share) * (1.0 - share);
    rigid_pose_interpolate(&self->from, &self->to, share, pose);
    for (int i = 0; i < 3; i++) {
        pose->position_m[i] += bow * self->bow_m[i];
    }
}
