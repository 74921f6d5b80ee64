/* A recorded motion from a CSV file (docs/recordings.md), checked line by line. */
#ifndef COMANIP_SIM_RECORDING_H
#define COMANIP_SIM_RECORDING_H

#include <stdbool.h>
#include <stddef.h>

#include "../common/rigid_pose.h"

#define RECORDING_MAX_SAMPLES 4000000
#define RECORDING_MAX_DURATION_S 86400.0
#define RECORDING_MAX_DISTANCE_M 1000.0
#define RECORDING_TOLERANCE 1e-3 /* largest deviation of a quaternion's norm from 1 or of R^T R from the identity */

typedef struct {
    double time_s;     /* since the first sample */
    rigid_pose_t pose; /* in the recorder's frame; the signs of the quaternions are continuous */
} recording_sample_t;

typedef struct {
    recording_sample_t *sample;
    size_t count; /* at least 2 */
    double median_interval_s;
} recording_t;

/* Reads the file. Returns false on failure; `error` then holds one line that names file, line, value and what was
 * expected, and nothing needs to be freed. */
bool recording_read(recording_t *self, const char *path, char error[], size_t error_size);

void recording_free(recording_t *self);

#endif
