/* The recordings that the steps of a person's program play. */
#ifndef COMANIP_SIM_PLAYLIST_H
#define COMANIP_SIM_PLAYLIST_H

#include <stdbool.h>
#include <stddef.h>

#include "../hand/playback.h"
#include "../scenario/scenario.h"

#define PLAYLIST_TEXT_BYTES 1024

/* Entry n belongs to step n. */
typedef struct {
    recorded_motion_t *recording[SCENARIO_MAX_STEPS]; /* NULL if the step plays no recording */
    playback_t playback[SCENARIO_MAX_STEPS];
    char description[PLAYLIST_TEXT_BYTES]; /* one line about the first recording; "" if there is none */
} playlist_t;

/* Opens the recordings of all steps. recording and axes, which may be NULL, come from the command line and apply to
 * steps that do not name a recording. Returns false on failure, with one line in `error`. playlist_close() must be
 * called in either case. */
bool playlist_open(playlist_t *self, const char *person, const person_step_t steps[], size_t count,
                   const char *recording, const char *axes, char error[], size_t error_size);
void playlist_close(playlist_t *self);

#endif
