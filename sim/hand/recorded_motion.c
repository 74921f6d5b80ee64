#include "recorded_motion.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "recording.h"

#define GAP_FACTOR 1.5 /* an interval longer than this factor times the median is a gap */
#define DESCRIPTION_BYTES 512

struct recorded_motion {
    recording_t recording;
    double gap_interval_s;
    char description[DESCRIPTION_BYTES];
};

/* Parses a map such as "-yxz". Row i of the matrix is axis i of the torso, in recorder axes. Returns false if the map
 * is malformed, repeats an axis or is left-handed. */
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

static void describe_recording(recorded_motion_t *self, const char *path, const char *axes) {
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
                   path, recording->count, recorded_motion_duration_s(self), 1.0 / recording->median_interval_s, gaps,
                   1e3 * longest_gap_s, axes);
}

recorded_motion_t *recorded_motion_create(const char *path, const char *axes, char error[], size_t error_size) {
    if (axes == NULL) {
        axes = default_axes(path);
    }
    double matrix[3][3];
    if (!parse_axes(axes, matrix)) {
        (void)snprintf(error, error_size,
                       "axes '%.20s': expected the recorder's axes that become the torso's x, y and z, right-handed, "
                       "for example xyz or -yxz",
                       axes);
        return NULL;
    }
    recorded_motion_t *self = calloc(1, sizeof *self);
    if (self == NULL) {
        (void)snprintf(error, error_size, "%s: not enough memory", path);
        return NULL;
    }
    if (!recording_read(&self->recording, path, error, error_size)) {
        free(self);
        return NULL;
    }
    double mapping[4];
    rotation_from_matrix((const double (*)[3])matrix, mapping);
    for (size_t i = 0; i < self->recording.count; i++) {
        rigid_pose_t *pose = &self->recording.sample[i].pose;
        rotation_multiply(mapping, pose->rotation, pose->rotation);
        rotation_apply(mapping, pose->position_m, pose->position_m);
    }
    self->gap_interval_s = GAP_FACTOR * self->recording.median_interval_s;
    describe_recording(self, path, axes);
    return self;
}

void recorded_motion_destroy(recorded_motion_t *self) {
    if (self != NULL) {
        recording_free(&self->recording);
        free(self);
    }
}

double recorded_motion_duration_s(const recorded_motion_t *self) {
    return self->recording.sample[self->recording.count - 1].time_s;
}

bool recorded_motion_sample(const recorded_motion_t *self, double time_s, rigid_pose_t *pose) {
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
    rigid_pose_interpolate(&sample[from].pose, &sample[to].pose, since_s / interval_s, pose);
    return interval_s <= self->gap_interval_s || since_s <= 0.0;
}

const char *recorded_motion_description(const recorded_motion_t *self) {
    return self->description;
}
