/* The tracker measures the hand at its own rate, in its own frame and with its own clock. */
#include "tracker_node.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../bus/endpoint.h"
#include "../common/random.h"
#include "../robot/robot_model.h"

struct tracker_node {
    endpoint_t endpoint;
    float range_m; /* largest position coordinate that a HandPose frame can carry */
    const hand_history_t *history;
    tracker_options_t options;
    rigid_pose_t torso_in_tracker;
    int64_t latency_ns;
    random_t noise;
    random_t dropout;
    uint64_t next_sample;
    uint64_t next_status;
    int64_t last_valid_ns;
    tracker_statistics_t statistics;
};

void tracker_options_set_defaults(tracker_options_t *options) {
    const double half_sqrt2 = 0.70710678118654752;
    *options = (tracker_options_t){
        .rate_hz = 250.0,
        .latency_s = 0.004,
        .noise_position_m = 0.00005,
        .noise_rotation_rad = 0.02 * 3.14159265358979324 / 180.0,
        .mount_translation_m = {0.3, 1.5, 0.2},
        .mount_rotation = {half_sqrt2, half_sqrt2, 0.0, 0.0}, /* 90 deg about x; the paper's equation (9) undoes it */
        .seed = 1,
    };
}

bool tracker_options_check(const tracker_options_t *options, char error[], size_t error_size) {
    const double norm = sqrt(rotation_dot(options->mount_rotation, options->mount_rotation));
    const struct {
        const char *name;
        double value, min, max;
    } range[] = {
        {"rate_hz", options->rate_hz, 15.0, 1000.0},
        {"latency_s", options->latency_s, 0.0, 0.5},
        {"noise_position_m", options->noise_position_m, 0.0, 1.0},
        {"noise_rotation_rad", options->noise_rotation_rad, 0.0, 1.0},
        {"mount_translation_m x", options->mount_translation_m[0], -1e3, 1e3},
        {"mount_translation_m y", options->mount_translation_m[1], -1e3, 1e3},
        {"mount_translation_m z", options->mount_translation_m[2], -1e3, 1e3},
        {"norm of mount_rotation", norm, 0.999, 1.001},
        {"dropout_probability", options->dropout_probability, 0.0, 1.0},
        {"gap_start_s", options->gap_start_s, 0.0, 1e6},
        {"gap_duration_s", options->gap_duration_s, 0.0, 1e6},
    };
    for (size_t i = 0; i < sizeof range / sizeof range[0]; i++) {
        if (!(range[i].value >= range[i].min && range[i].value <= range[i].max)) {
            (void)snprintf(error, error_size, "tracker: %s is %.9g, expected %g to %g", range[i].name, range[i].value,
                           range[i].min, range[i].max);
            return false;
        }
    }
    return true;
}

tracker_node_t *tracker_node_create(bus_t *bus, const hand_history_t *history, const tracker_options_t *options) {
    tracker_node_t *self = calloc(1, sizeof *self);
    if (self == NULL) {
        return NULL;
    }
    self->range_m = transport_hand_range_m(bus_profile(bus));
    endpoint_attach(&self->endpoint, bus, ROBOT_JOINTS, 0, NULL, NULL);
    self->history = history;
    self->options = *options;
    self->latency_ns = llround(options->latency_s * 1e9);
    rigid_pose_t mount;
    memcpy(mount.position_m, options->mount_translation_m, sizeof mount.position_m);
    memcpy(mount.rotation, options->mount_rotation, sizeof mount.rotation);
    rotation_normalise(mount.rotation);
    self->torso_in_tracker = rigid_pose_inverse(&mount);
    random_init(&self->noise, options->seed, "tracker noise");
    random_init(&self->dropout, options->seed, "tracker dropout");
    return self;
}

void tracker_node_destroy(tracker_node_t *self) {
    free(self);
}

static uint32_t clock_us(const tracker_node_t *self, int64_t time_ns) {
    return self->options.clock_start_us + (uint32_t)(time_ns / 1000);
}

/* Adds noise to a pose. Must be called for every sample, even for a lost one, so that a dropout does not change the
 * noise of later samples. */
static void add_noise(tracker_node_t *self, rigid_pose_t *pose) {
    double turn_rad[3];
    for (int i = 0; i < 3; i++) {
        pose->position_m[i] += self->options.noise_position_m * random_gaussian(&self->noise);
    }
    for (int i = 0; i < 3; i++) {
        turn_rad[i] = self->options.noise_rotation_rad * random_gaussian(&self->noise);
    }
    double turn[4];
    rotation_from_vector(turn_rad, turn);
    rotation_multiply(pose->rotation, turn, pose->rotation);
}

/* Measures the pose of the marker in the tracker frame. Returns false if the tracker does not see it. */
static bool measure(tracker_node_t *self, int64_t time_ns, rigid_pose_t *marker) {
    const double time_s = (double)time_ns * 1e-9;
    const double since_gap_s = time_s - self->options.gap_start_s;
    const bool in_gap = since_gap_s >= 0.0 && since_gap_s < self->options.gap_duration_s;
    const bool dropped = random_uniform(&self->dropout) < self->options.dropout_probability;

    rigid_pose_t hand = {.rotation = {1.0, 0.0, 0.0, 0.0}};
    const bool has_pose = hand_history_sample(self->history, time_ns, &hand);
    *marker = rigid_pose_multiply(&self->torso_in_tracker, &hand);
    add_noise(self, marker);
    return has_pose && !in_gap && !dropped;
}

/* Returns true if the position fits into a HandPose frame. NaN does not fit. */
static bool is_in_range(const tracker_node_t *self, const hand_pose_t *pose) {
    return fabsf(pose->position_m.x) <= self->range_m && fabsf(pose->position_m.y) <= self->range_m &&
           fabsf(pose->position_m.z) <= self->range_m;
}

static void send_hand_pose(tracker_node_t *self, int64_t measured_ns, int64_t ready_ns) {
    rigid_pose_t marker;
    hand_pose_t pose = {.t_us = clock_us(self, measured_ns), .rotation = {.w = 1.0F}};
    if (measure(self, measured_ns, &marker)) {
        pose.valid = true;
        pose.position_m = (vector3_t){
            .x = (float)marker.position_m[0], .y = (float)marker.position_m[1], .z = (float)marker.position_m[2]};
        pose.rotation = (quaternion_t){.w = (float)marker.rotation[0],
                                       .x = (float)marker.rotation[1],
                                       .y = (float)marker.rotation[2],
                                       .z = (float)marker.rotation[3]};
    }
    if (pose.valid && !is_in_range(self, &pose)) {
        self->statistics.range_errors++;
        pose = (hand_pose_t){.t_us = pose.t_us, .rotation = {.w = 1.0F}};
    }
    can_frame_t frame;
    (void)hand_pose_pack(&pose, &frame);
    if (self->statistics.samples == 0) {
        self->last_valid_ns = measured_ns; /* if the run begins with a gap, the gap starts with the first sample */
    }
    self->statistics.longest_gap_s =
        fmax(self->statistics.longest_gap_s, (double)(measured_ns - self->last_valid_ns) * 1e-9);
    if (pose.valid) {
        self->last_valid_ns = measured_ns;
    }
    self->statistics.samples++;
    self->statistics.lost += !pose.valid;
    endpoint_send(&self->endpoint, &frame, ready_ns);
}

static void send_status(tracker_node_t *self, int64_t ready_ns) {
    const tracker_status_t status = {
        .t_us = clock_us(self, ready_ns),
        .period_us = (uint32_t)lround(1e6 / self->options.rate_hz),
        .latency_us = (uint32_t)lround(1e6 * self->options.latency_s),
        .fault = 0,
        .lost_samples = (uint16_t)self->statistics.lost,
        .range_errors = (uint16_t)self->statistics.range_errors,
    };
    can_frame_t frame;
    (void)tracker_status_pack(&status, &frame); /* cannot fail after tracker_options_check() */
    endpoint_send(&self->endpoint, &frame, ready_ns);
}

void tracker_node_step(tracker_node_t *self, int64_t from_ns, int64_t until_ns) {
    const int64_t status_period_ns =
        (int64_t)transport_period_ms(self->endpoint.sender.profile, FRAME_TRACKER_STATUS) * 1000000;
    for (;;) { /* sends in chronological order, so that a status's counters do not depend on the step length */
        const int64_t measured_ns = llround((double)self->next_sample * 1e9 / self->options.rate_hz);
        const int64_t pose_ns = measured_ns + self->latency_ns;
        const int64_t status_ns = (int64_t)self->next_status * status_period_ns;
        if (pose_ns >= until_ns && status_ns >= until_ns) {
            break;
        }
        if (pose_ns <= status_ns) {
            self->next_sample++;
            if (pose_ns >= from_ns) {
                send_hand_pose(self, measured_ns, pose_ns);
            }
        } else {
            self->next_status++;
            if (status_ns >= from_ns) {
                send_status(self, status_ns);
            }
        }
    }
}

tracker_statistics_t tracker_node_statistics(const tracker_node_t *self) {
    return self->statistics;
}
