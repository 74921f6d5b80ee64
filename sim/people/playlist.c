#include "playlist.h"

#include <stdio.h>

static bool open_entry(playlist_t *self, size_t n, const person_step_t *step, const char *path, const char *axes,
                       char error[], size_t error_size) {
    self->recording[n] = recorded_motion_create(path, axes, error, error_size);
    if (self->recording[n] == NULL) {
        return false;
    }
    const double duration_s = recorded_motion_duration_s(self->recording[n]);
    const double until_s = step->until_s > 0.0 ? step->until_s : duration_s;
    if (!(step->from_s >= 0.0 && step->from_s < until_s && until_s <= duration_s)) {
        (void)snprintf(error, error_size,
                       "%s: from_s %g, until_s %g: expected 0 <= from_s < until_s <= %g, the duration in s", path,
                       step->from_s, until_s, duration_s);
        return false;
    }
    playback_init(&self->playback[n], self->recording[n], step->from_s, until_s, step->position_scale,
                  step->rotation_scale);
    return true;
}

static void describe(playlist_t *self, const char *person, size_t n) {
    const playback_t *playback = &self->playback[n];
    (void)snprintf(self->description, sizeof self->description,
                   "%s: %s; played from %.2f s until %.2f s, positions times %g, rotations times %g", person,
                   recorded_motion_description(self->recording[n]), playback->from_s, playback->until_s,
                   playback->position_scale, playback->rotation_scale);
}

bool playlist_open(playlist_t *self, const char *person, const person_step_t steps[], size_t count,
                   const char *recording, const char *axes, char error[], size_t error_size) {
    *self = (playlist_t){.description = ""};
    for (size_t n = 0; n < count; n++) {
        const person_step_t *step = &steps[n];
        if (step->action != PERSON_PLAY) {
            continue;
        }
        const bool own = step->recording[0] != '\0';
        const char *path = own ? step->recording : recording;
        const char *own_axes = step->axes[0] != '\0' ? step->axes : NULL;
        if (path == NULL) {
            (void)snprintf(error, error_size,
                           "%s: step %zu plays a recording, expected the path of a CSV file in its key `recording`",
                           person, n + 1);
            return false;
        }
        if (!open_entry(self, n, step, path, own || axes == NULL ? own_axes : axes, error, error_size)) {
            return false;
        }
        if (self->description[0] == '\0') {
            describe(self, person, n);
        }
    }
    return true;
}

void playlist_close(playlist_t *self) {
    for (size_t n = 0; n < SCENARIO_MAX_STEPS; n++) {
        recorded_motion_destroy(self->recording[n]);
    }
}
