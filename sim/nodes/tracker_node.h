/* The motion tracker as a node on the bus: measures the actual hand and sends HandPose and TrackerStatus. */
#ifndef COMANIP_SIM_TRACKER_NODE_H
#define COMANIP_SIM_TRACKER_NODE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "../bus/bus.h"
#include "../hand/hand_history.h"

/* Times are simulation times unless stated otherwise. */
typedef struct {
    double rate_hz;                     /* rate of HandPose on the bus, 15..1000; sample k is measured at k / rate_hz */
    double latency_s;                   /* time from measuring to sending, 0..0.5; reported in TrackerStatus */
    double noise_position_m;            /* standard deviation per axis */
    double noise_rotation_rad;          /* standard deviation per axis of the rotation vector */
    double mount_translation_m[3];      /* with mount_rotation: the tracker's pose in the torso frame (q_E^T) */
    double mount_rotation[4];           /* unit quaternion w x y z */
    double dropout_probability;         /* probability that a sample is lost, 0..1 */
    double gap_start_s, gap_duration_s; /* samples measured in this interval are lost; duration 0: no gap */
    uint32_t clock_start_us;            /* initial time of the tracker's own clock, which wraps at 2^32 us */
    uint64_t seed;
} tracker_options_t;

typedef struct {
    uint64_t samples;      /* samples sent */
    uint64_t lost;         /* samples sent as invalid */
    uint64_t range_errors; /* lost samples whose position was beyond the frame's range */
    double longest_gap_s;  /* longest time without a valid sample, which may be before the first or after the last */
} tracker_statistics_t;

typedef struct tracker_node tracker_node_t;

/* Sets the defaults: 250 Hz, 4 ms latency, noise of 0.05 mm and 0.02 degrees, mounted on the robot's left as in the
 * paper's equation (9), no dropouts. */
void tracker_options_set_defaults(tracker_options_t *options);

/* Returns false if an option is outside the ranges above; `error` then holds one line that names the option, its
 * value and its range. */
bool tracker_options_check(const tracker_options_t *options, char error[], size_t error_size);

/* The bus and the history must outlive the node; tracker_options_check() must accept the options. Returns NULL if out
 * of memory. */
tracker_node_t *tracker_node_create(bus_t *bus, const hand_history_t *history, const tracker_options_t *options);
void tracker_node_destroy(tracker_node_t *self);

/* Queues the frames that are due in [from_ns, until_ns). A HandPose is due latency_s after its measurement, and a
 * TrackerStatus once per period. Frames that were due before from_ns are skipped. The history must reach up to
 * from_ns. */
void tracker_node_step(tracker_node_t *self, int64_t from_ns, int64_t until_ns);

tracker_statistics_t tracker_node_statistics(const tracker_node_t *self);

#endif
