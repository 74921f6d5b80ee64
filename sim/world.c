#include "world.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#define TICK_S (WORLD_TICK_NS * 1e-9)
#define RECORDING_REST_S 1.0 /* a recording's run goes on for so long after its end */

static void log_frame(void *context, const can_frame_t *frame, int64_t end_ns) {
    candump_log_write(context, frame, end_ns);
}

double world_duration_s(const options_t *options, const hand_motion_t *motion) {
    if (options->duration_s > 0.0) {
        return options->duration_s;
    }
    if (options->tracker_path != NULL) {
        return options->tracker.motion_start_s + hand_motion_duration_s(motion) + RECORDING_REST_S;
    }
    return options->scenario->duration_s;
}

static bool create_nodes(world_t *self, const hand_motion_t *motion, double run_s) {
    const options_t *options = self->options;
    double start_rad[ROBOT_JOINTS];
    for (int i = 0; i < ROBOT_JOINTS; i++) {
        start_rad[i] = options->scenario->start_deg[i] * ROBOT_RAD_PER_DEG;
    }
    operator_step_t steps[SCENARIO_MAX_STEPS];
    const size_t step_count =
        scenario_script(options->scenario, run_s, &options->operator, steps);
    self->bus = bus_create();
    self->plant = arm_plant_create(start_rad);
    if (self->bus == NULL || self->plant == NULL) {
        return false;
    }
    self->drives = drive_node_create(self->bus, self->plant);
    self->tracker = tracker_node_create(self->bus, motion, &options->tracker);
    self->operator = operator_node_create(self->bus, steps, step_count);
    return self->drives != NULL && self->tracker != NULL && self->operator != NULL;
}

bool world_init(world_t *self, const options_t *options, const hand_motion_t *motion, const char *log_path,
                const char *trace_path, const volatile sig_atomic_t *interrupted, char error[], size_t error_size) {
    memset(self, 0, sizeof *self);
    self->options = options;
    self->interrupted = interrupted;
    const double run_s = world_duration_s(options, motion);
    self->end_ns = (int64_t)(run_s / TICK_S + 0.5) * WORLD_TICK_NS;
    if (!create_nodes(self, motion, run_s)) {
        (void)snprintf(error, error_size, "no memory for the simulated world");
        return false;
    }
    observer_init(&self->observer, self->bus);
    for (int i = 0; i < ROBOT_JOINTS; i++) { /* in the first tick the drives have not yet been asked */
        self->observer.tick.measured_rad[i] = drive_node_encoder_rad(self->drives, i);
    }
    tracking_init(&self->tracking);
    scenario_monitor_init(&self->scenario_monitor, options->scenario->checks,
                          world_is_scripted(self) ? options->scenario->check_count : 0);
    self->log = candump_log_open(log_path, error, error_size);
    if (self->log == NULL || !trace_csv_open(&self->trace, trace_path, error, error_size)) {
        return false;
    }
    bus_listen(self->bus, log_frame, self->log);
    return true;
}

bool world_is_scripted(const world_t *self) {
    return self->options->tracker_path == NULL && !self->options->operator.defines_task;
}

void world_fail(world_t *self, const char *reason) {
    if (self->failure[0] == '\0') {
        (void)snprintf(self->failure, sizeof self->failure, "%s", reason);
    }
}

/* An operator who waits in vain, and a tracker that never told a pose: the cause may be the file. */
static void fail_as_operator(world_t *self) {
    const char *reason = operator_node_failure(self->operator);
    const tracker_statistics_t tracker = tracker_node_statistics(self->tracker);
    char text[WORLD_TEXT_BYTES];
    if (tracker.samples == 0 || tracker.lost < tracker.samples) {
        world_fail(self, reason);
        return;
    }
    if (tracker.range_errors == 0) {
        (void)snprintf(text, sizeof text, "%s; the tracker lost all %" PRIu64 " samples", reason, tracker.samples);
    } else {
        (void)snprintf(text, sizeof text,
                       "%s; %s%" PRIu64 " samples are beyond the %.3f m a frame can carry: is the file in mm, or the "
                       "tracker mounted too far away?",
                       reason, tracker.range_errors == tracker.samples ? "all " : "", tracker.range_errors,
                       TRACKER_RANGE_M);
    }
    world_fail(self, text);
}

static bool is_over(world_t *self) {
    if (operator_node_failure(self->operator) != NULL) {
        fail_as_operator(self);
    }
    if (self->observer.out_of_memory) {
        world_fail(self, "no memory for the list of modes");
    }
    if (*self->interrupted != 0) {
        world_fail(self, "interrupted");
    }
    return self->failure[0] != '\0' || self->now_ns >= self->end_ns;
}

bool world_advance(world_t *self) {
    if (is_over(self)) {
        return false;
    }
    const int64_t now_ns = self->now_ns, next_ns = now_ns + WORLD_TICK_NS;
    rigid_pose_t hand;
    arm_plant_hand(self->plant, &hand);
    observer_begin_tick(&self->observer, now_ns, &hand);

    tracker_node_step(self->tracker, now_ns, next_ns);   /* queue what falls due in this tick */
    operator_node_step(self->operator, now_ns, next_ns);
    bus_run_until(self->bus, next_ns);                   /* drives latch their commands and sample their encoders */
    drive_node_step(self->drives, next_ns, TICK_S);      /* commands -> motors */
    arm_plant_step(self->plant, TICK_S);                 /* motors -> motion */

    const tick_record_t *tick = &self->observer.tick;
    tracking_sample(&self->tracking, tick, self->observer.parameter);
    scenario_monitor_sample(&self->scenario_monitor, tick,
                            (double)self->observer.parameter[PARAMETER_MOTION_SCALE]);
    trace_csv_write(&self->trace, tick);
    self->now_ns = next_ns;
    self->ticks++;
    if (self->on_tick != NULL) {
        self->on_tick(self);
    }
    return true;
}

bool world_close_files(world_t *self, const char *trace_path, char error[], size_t error_size) {
    const bool trace_closed = trace_csv_close(&self->trace, trace_path, error, error_size);
    candump_log_t *log = self->log;
    self->log = NULL;
    return candump_log_close(log, error, error_size) && trace_closed;
}

void world_free(world_t *self) {
    operator_node_destroy(self->operator);
    tracker_node_destroy(self->tracker);
    drive_node_destroy(self->drives);
    arm_plant_destroy(self->plant);
    bus_destroy(self->bus);
    observer_free(&self->observer);
}
