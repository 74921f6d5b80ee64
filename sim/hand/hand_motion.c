/* Motions of the hand: minimum-jerk legs, and recordings with their axes mapped to the torso's. */
#include "hand_motion.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "recording.h"

#define GAP_FACTOR 1.5 /* times the median interval */
#define DESCRIPTION_BYTES 512

/* The end of a leg; the first is the start itself, at time 0. */
typedef struct {
    double time_s;
    rigid_pose_t pose; /* its quaternion on the side of the one before */
} leg_end_t;

struct hand_motion {
    leg_end_t *leg_end; /* leg_count + 1; NULL: a recording */
    size_t leg_count;
    recording_t recording;
    double gap_interval_s;
    char description[DESCRIPTION_BYTES];
};

static void interpolate(const rigid_pose_t *a, const rigid_pose_t *b, double fraction, rigid_pose_t *pose) {
    for (int i = 0; i < 3; i++) {
        pose->position_m[i] = a->position_m[i] + fraction * (b->position_m[i] - a->position_m[i]);
    }
    rotation_interpolate(a->rotation, b->rotation, fraction, pose->rotation);
}

/* ---- minimum-jerk legs */

hand_motion_t *hand_motion_create_legs(const rigid_pose_t *start, const motion_leg_t legs[], size_t count) {
    hand_motion_t *self = calloc(1, sizeof *self);
    leg_end_t *leg_end = calloc(count + 1, sizeof *leg_end);
    if (self == NULL || leg_end == NULL) {
        free(leg_end);
        free(self);
        return NULL;
    }
    self->leg_end = leg_end;
    self->leg_count = count;
    leg_end[0] = (leg_end_t){.time_s = 0.0, .pose = *start};
    for (size_t n = 0; n < count; n++) {
        assert(legs[n].duration_s > 0.0);
        leg_end_t *end = &leg_end[n + 1];
        end->time_s = leg_end[n].time_s + legs[n].duration_s;
        double turn[4];
        rotation_from_vector(legs[n].rotation_vector_rad, turn);
        rotation_multiply(turn, start->rotation, end->pose.rotation);
        const double side = rotation_dot(leg_end[n].pose.rotation, end->pose.rotation) < 0.0 ? -1.0 : 1.0;
        for (int i = 0; i < 4; i++) {
            end->pose.rotation[i] *= side;
        }
        for (int i = 0; i < 3; i++) {
            end->pose.position_m[i] = start->position_m[i] + legs[n].displacement_m[i];
        }
    }
    (void)snprintf(self->description, sizeof self->description, "minimum-jerk motion: legs %zu, %.2f s", count,
                   leg_end[count].time_s);
    return self;
}

static void sample_legs(const hand_motion_t *self, double time_s, rigid_pose_t *pose) {
    size_t n = 0;
    while (n < self->leg_count && self->leg_end[n + 1].time_s <= time_s) {
        n++;
    }
    if (n == self->leg_count || time_s <= 0.0) {
        *pose = self->leg_end[n].pose;
        return;
    }
    const leg_end_t *from = &self->leg_end[n];
    const leg_end_t *to = &self->leg_end[n + 1];
    const double x = (time_s - from->time_s) / (to->time_s - from->time_s);
    interpolate(&from->pose, &to->pose, x * x * x * (10.0 + x * (6.0 * x - 15.0)), pose);
}

/* ---- recordings */

/* Row i: the torso's axis i in recorder axes. False: not three different axes, or left-handed. */
static bool parse_axes(const char *axes, double matrix[3][3]) {
    memset(matrix, 0, 9 * sizeof(double));
    int axis[3];
    double sign[3];
    for (int i = 0; i < 3; i++) {
        sign[i] = *axes == '-' ? -1.0 : 1.0;
        axes += *axes == '-';
        if (*axes < 'x' || *axes > 'z') {
            return false;
        }
        axis[i] = *axes++ - 'x';
        matrix[i][axis[i]] = sign[i];
    }
    if (*axes != '\0' || axis[0] == axis[1] || axis[1] == axis[2] || axis[2] == axis[0]) {
        return false;
    }
    const bool even = axis[1] == (axis[0] + 1) % 3;
    return sign[0] * sign[1] * sign[2] == (even ? 1.0 : -1.0);
}

static const char *default_axes(const char *path) {
    const char *slash = strrchr(path, '/');
    const char *name = slash == NULL ? path : slash + 1;
    const bool y_up = strncmp(name, "cmu_", 4) == 0 || strncmp(name, "ktk_", 4) == 0;
    return y_up ? "zxy" : "xyz";
}

static void describe_recording(hand_motion_t *self, const char *path, const char *axes) {
    const recording_t *recording = &self->recording;
    size_t gaps = 0;
    double longest_gap_s = 0.0;
    for (size_t i = 0; i + 1 < recording->count; i++) {
        const double interval_s = recording->sample[i + 1].time_s - recording->sample[i].time_s;
        gaps += interval_s > self->gap_interval_s;
        if (interval_s > self->gap_interval_s && interval_s > longest_gap_s) {
            longest_gap_s = interval_s;
        }
    }
    (void)snprintf(self->description, sizeof self->description,
                   "recording %.300s: samples %zu, %.2f s, %.1f Hz, gaps %zu (longest %.0f ms), "
                   "torso x y z = recorder %s",
                   path, recording->count, hand_motion_duration_s(self), 1.0 / recording->median_interval_s, gaps,
                   1e3 * longest_gap_s, axes);
}

hand_motion_t *hand_motion_create_recording(const char *path, const char *axes, char error[], size_t error_size) {
    if (axes == NULL) {
        axes = default_axes(path);
    }
    double matrix[3][3];
    if (!parse_axes(axes, matrix)) {
        (void)snprintf(error, error_size,
                       "axes '%.20s': expected the recorder axes of the torso's x, y and z, right-handed, "
                       "as in xyz or -yxz",
                       axes);
        return NULL;
    }
    hand_motion_t *self = calloc(1, sizeof *self);
    if (self == NULL) {
        (void)snprintf(error, error_size, "%s: not enough memory", path);
        return NULL;
    }
    if (!recording_read(&self->recording, path, error, error_size)) {
        free(self);
        return NULL;
    }
    double mapping[4];
    rotation_from_matrix((const double(*)[3])matrix, mapping);
    for (size_t i = 0; i < self->recording.count; i++) {
        rigid_pose_t *pose = &self->recording.sample[i].pose;
        rotation_multiply(mapping, pose->rotation, pose->rotation);
        rotation_apply(mapping, pose->position_m, pose->position_m);
    }
    self->gap_interval_s = GAP_FACTOR * self->recording.median_interval_s;
    describe_recording(self, path, axes);
    return self;
}

static bool sample_recording(const hand_motion_t *self, double time_s, rigid_pose_t *pose) {
    const recording_sample_t *sample = self->recording.sample;
    size_t from = 0;
    size_t to = self->recording.count - 1;
    if (time_s <= sample[from].time_s || time_s >= sample[to].time_s) {
        *pose = time_s <= sample[from].time_s ? sample[from].pose : sample[to].pose;
        return true;
    }
    while (to - from > 1) {
        const size_t middle = from + (to - from) / 2;
        if (sample[middle].time_s <= time_s) {
            from = middle;
        } else {
            to = middle;
        }
    }
    const double interval_s = sample[to].time_s - sample[from].time_s;
    const double since_s = time_s - sample[from].time_s;
    if (interval_s > self->gap_interval_s && since_s > 0.0) {
        return false;
    }
    interpolate(&sample[from].pose, &sample[to].pose, since_s / interval_s, pose);
    return true;
}

/* ---- both */

void hand_motion_destroy(hand_motion_t *self) {
    if (self != NULL) {
        recording_free(&self->recording);
        free(self->leg_end);
        free(self);
    }
}

double hand_motion_duration_s(const hand_motion_t *self) {
    if (self->leg_end != NULL) {
        return self->leg_end[self->leg_count].time_s;
    }
    return self->recording.sample[self->recording.count - 1].time_s;
}

bool hand_motion_sample(const hand_motion_t *self, double time_s, rigid_pose_t *pose) {
    if (self->leg_end != NULL) {
        sample_legs(self, time_s, pose);
        return true;
    }
    return sample_recording(self, time_s, pose);
}

const char *hand_motion_description(const hand_motion_t *self) {
    return self->description;
}
