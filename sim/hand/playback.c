#include "playback.h"

#include <math.h>

void playback_init(playback_t *self, const recorded_motion_t *motion, double from_s, double until_s,
                   double position_scale, double rotation_scale) {
    *self = (playback_t){
        .motion = motion,
        .from_s = from_s,
        .until_s = until_s > 0.0 ? until_s : recorded_motion_duration_s(motion),
        .position_scale = position_scale,
        .rotation_scale = rotation_scale,
    };
    (void)recorded_motion_sample(motion, from_s, &self->first);
}

void playback_begin(playback_t *self, double begin_s, const rigid_pose_t *here) {
    self->begin_s = begin_s;
    self->here = *here;
}

double playback_duration_s(const playback_t *self) {
    return self->until_s - self->from_s;
}

/* Scales the angle of a rotation. The angle is between 0 and 2 pi and does not jump at pi, because the quaternion signs
 * of a recording are continuous. */
static void scale_rotation(const double rotation[4], double scale, double scaled[4]) {
    const double sine = sqrt(rotation[1] * rotation[1] + rotation[2] * rotation[2] + rotation[3] * rotation[3]);
    const double angle = 2.0 * atan2(sine, rotation[0]);
    const double factor = sine > 0.0 ? scale * angle / sine : 0.0;
    const double vector_rad[3] = {factor * rotation[1], factor * rotation[2], factor * rotation[3]};
    rotation_from_vector(vector_rad, scaled);
}

bool playback_sample(const playback_t *self, double time_s, rigid_pose_t *pose) {
    const double since_s = fmin(fmax(time_s - self->begin_s, 0.0), playback_duration_s(self));
    rigid_pose_t recorded;
    const bool visible = recorded_motion_sample(self->motion, self->from_s + since_s, &recorded);
    for (int i = 0; i < 3; i++) {
        const double displacement_m = recorded.position_m[i] - self->first.position_m[i];
        pose->position_m[i] = self->here.position_m[i] + self->position_scale * displacement_m;
    }
    const double *first = self->first.rotation;
    const double first_inverse[4] = {first[0], -first[1], -first[2], -first[3]};
    double turned[4];
    rotation_multiply(recorded.rotation, first_inverse, turned);
    scale_rotation(turned, self->rotation_scale, turned);
    rotation_multiply(turned, self->here.rotation, pose->rotation);
    rotation_normalise(pose->rotation);
    return visible;
}
