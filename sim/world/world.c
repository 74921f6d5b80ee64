#include "world.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define TICK_S (WORLD_TICK_NS * 1e-9)

static int64_t ns_from_s(double seconds) {
    return (int64_t)(seconds / TICK_S + 0.5) * WORLD_TICK_NS;
}

static bool create_people(world_t *self, char error[], size_t error_size) {
    const options_t *options = self->options;
    for (size_t i = 0; i < self->scenario->person_count; i++) {
        const char *recording = i == self->scenario->tracked ? options->tracker_path : options->second_path;
        self->program[i] = person_program_create(self->scenario, i, self->scene, &self->events, recording,
                                                 options->axes, options->seed, error, error_size);
        if (self->program[i] == NULL) {
            return false;
        }
    }
    return true;
}

static bool create_nodes(world_t *self) {
    operator_step_t steps[OPERATOR_SCRIPT_MAX_STEPS];
    const size_t step_count = operator_script(self->scenario, &self->options->operator, steps);
    self->drives = drive_node_create(self->bus, scene_arm(self->scene));
    self->gripper = gripper_node_create(self->bus, self->scene);
    self->tracker = tracker_node_create(self->bus, self->hand_history, &self->options->tracker);
    self->proximity_sensor = proximity_node_create(self->bus);
    self->operator = operator_node_create(self->bus, &self->events, steps, step_count);
    return self->drives != NULL && self->gripper != NULL && self->tracker != NULL && self->proximity_sensor != NULL &&
           self->operator != NULL;
}

bool world_init(world_t *self, const options_t *options, const scenario_t *scenario, bus_t *bus,
                const volatile sig_atomic_t *interrupted, char error[], size_t error_size) {
    memset(self, 0, sizeof *self);
    self->options = options;
    self->scenario = scenario;
    self->bus = bus;
    self->interrupted = interrupted;
    self->events = scenario->events;
    self->stop_s = -1.0;
    self->has_fixed_end = options->duration_s > 0.0;
    self->is_shortened = self->has_fixed_end && options->duration_s < scenario->duration_s;
    self->has_recording = options->tracker_path != NULL || options->second_path != NULL;
    self->end_ns = ns_from_s(self->has_fixed_end ? options->duration_s : scenario->duration_s);
    self->scene = scene_create(scenario, &self->events);
    self->hand_history = hand_history_create();
    if (self->scene == NULL || self->hand_history == NULL) {
        (void)snprintf(error, error_size, "not enough memory for the simulated world");
        return false;
    }
    if (!create_people(self, error, error_size)) {
        return false;
    }
    self->proximity = proximity_create(scenario, self->scene);
    if (self->proximity == NULL || !create_nodes(self)) {
        (void)snprintf(error, error_size, "not enough memory for the simulated world");
        return false;
    }
    observer_init(&self->observer, self->bus, options->tracker.clock_start_us);
    for (int i = 0; i < ROBOT_JOINTS; i++) { /* until a drive reports its position, its encoder is read here */
        self->observer.tick.measured_rad[i] = drive_node_encoder_rad(self->drives, i);
    }
    tracking_init(&self->tracking);
    largest_scale_init(&self->largest_scale);
    rest_monitor_init(&self->rest);
    latency_init(&self->latency);
    scenario_monitor_init(&self->scenario_monitor, scenario);
    contact_monitor_init(&self->contact_monitor);
    return true;
}

bool world_is_scripted(const world_t *self) {
    return !self->has_recording && !self->options->operator.defines_task;
}

void world_fail(world_t *self, const char *reason) {
    if (self->failure[0] == '\0') {
        (void)snprintf(self->failure, sizeof self->failure, "%s", reason);
    }
}

/* Fails the run with the reason why the operator failed. If the tracker never reported a valid pose, the reason also
 * says so, because then the recording may have caused the failure. */
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
        const double range_m = floor(1e3 * (double)transport_hand_range_m(bus_profile(self->bus))) * 1e-3;
        (void)snprintf(text, sizeof text,
                       "%s; %s%" PRIu64 " samples are beyond the %.3f m that a HandPose frame can carry: is the file "
                       "in mm, or is the tracker mounted too far away?",
                       reason, tracker.range_errors == tracker.samples ? "all " : "", tracker.range_errors, range_m);
    }
    world_fail(self, text);
}

static bool all_scripts_done(const world_t *self) {
    bool done = operator_node_script_done(self->operator);
    for (size_t i = 0; i < self->scenario->person_count; i++) {
        done = done && person_program_is_done(self->program[i]);
    }
    return done;
}

/* Fails the run with a reason that names the current step of each person and of the operator. */
static void fail_as_overdue(world_t *self) {
    char text[WORLD_TEXT_BYTES];
    size_t used = (size_t)snprintf(text, sizeof text,
                                   "not everything was done in the scenario's %g s: ", self->scenario->duration_s);
    for (size_t i = 0; i < self->scenario->person_count; i++) {
        person_program_describe(self->program[i], text + used, sizeof text - used);
        used = strlen(text);
        used += (size_t)snprintf(text + used, sizeof text - used, ", ");
    }
    operator_node_describe(self->operator, text + used, sizeof text - used);
    world_fail(self, text);
}

/* Lets the operator stop the arm half a second before the end of the run or, unless --duration was given, as soon as
 * all scripts are done. */
static void stop_when_due(world_t *self) {
    const int64_t closing_ns = ns_from_s(SCENARIO_STOP_BEFORE_END_S);
    const bool is_done = all_scripts_done(self);
    const bool is_overdue =
        !is_done && !self->is_shortened && self->now_ns >= ns_from_s(self->scenario->duration_s) - closing_ns;
    const bool is_late = self->now_ns >= self->end_ns - closing_ns;
    if (self->stop_s >= 0.0 || !(is_overdue || is_late || (is_done && !self->has_fixed_end))) {
        return;
    }
    if (is_overdue) {
        fail_as_overdue(self);
    }
    self->stop_s = (double)self->now_ns * 1e-9;
    operator_node_stop(self->operator);
    if (!self->has_fixed_end) {
        self->end_ns = self->now_ns + closing_ns;
    }
}

static bool is_over(world_t *self) {
    if (operator_node_failure(self->operator) != NULL) {
        fail_as_operator(self);
    }
    for (size_t i = 0; i < self->scenario->person_count; i++) {
        if (person_program_failure(self->program[i]) != NULL) {
            world_fail(self, person_program_failure(self->program[i]));
        }
    }
    if (self->observer.out_of_memory) {
        world_fail(self, "not enough memory for the list of modes");
    }
    if (*self->interrupted != 0) {
        world_fail(self, "interrupted");
    }
    return self->failure[0] != '\0' || self->now_ns >= self->end_ns;
}

/* Reads the state of the scene at now_ns for the monitors, the trace and the sensors. */
static void look(world_t *self) {
    self->clearance = proximity_measure(self->proximity);
    physical_state_read(&self->state, self->scenario, self->scene, &self->clearance);
    hand_history_push(self->hand_history, self->now_ns, &self->state.hand[self->scenario->tracked],
                      !person_program_is_hidden(self->program[self->scenario->tracked]));
    rigid_pose_t hand;
    arm_plant_hand(scene_arm(self->scene), &hand);
    observer_begin_tick(&self->observer, self->now_ns, &hand);
}

/* Computes the displacement of the end effector per displacement of the person's hand, for each axis. */
static void robot_gain(const world_t *self, double scale[3]) {
    const double motion_scale = (double)self->observer.parameter[PARAMETER_MOTION_SCALE];
    for (int k = 0; k < 3; k++) {
        scale[k] = motion_scale;
    }
    scale[0] *= operator_node_mirrors(self->operator) ? -1.0 : 1.0;
}

/* Moves people and scene through the tick that begins at now_ns. A physics step longer than a tick is computed entirely
 * in the first of its ticks. */
static void move(world_t *self) {
    const int64_t step_ns = (int64_t)self->options->physics_step_us * 1000;
    const double step_s = (double)step_ns * 1e-9;
    double gain[3];
    robot_gain(self, gain);
    for (int64_t from_ns = self->now_ns; from_ns < self->now_ns + WORLD_TICK_NS; from_ns += step_ns) {
        if (from_ns % step_ns != 0) {
            return;
        }
        const double from_s = (double)from_ns * 1e-9;
        for (size_t i = 0; i < self->scenario->person_count; i++) {
            person_program_step(self->program[i], from_s, from_s + step_s, gain);
        }
        scene_step(self->scene, from_s, step_s);
    }
}

static void watch_recording(world_t *self) {
    if (self->options->tracker_path != NULL && person_program_plays(self->program[self->scenario->tracked])) {
        largest_scale_sample(&self->largest_scale, &self->observer.tick);
    } else {
        largest_scale_pause(&self->largest_scale);
    }
}

static void watch(world_t *self) {
    const tick_record_t *tick = &self->observer.tick;
    const rigid_pose_t aim = person_program_aim(self->program[self->scenario->tracked]);
    tracking_sample(&self->tracking, tick, self->observer.parameter);
    watch_recording(self);
    rest_monitor_sample(&self->rest, tick, &self->state, &aim, self->observer.settled_ns);
    double gain[3];
    robot_gain(self, gain);
    latency_sample(&self->latency, tick, &self->state.hand[self->scenario->tracked], gain, self->observer.settled_ns,
                   tracking_is_followable(&self->tracking, tick));
    scenario_monitor_sample(&self->scenario_monitor, tick, &self->state, &self->events,
                            (double)self->observer.parameter[PARAMETER_MOTION_SCALE]);
    contact_monitor_sample(&self->contact_monitor, tick, &self->state);
}

bool world_advance(world_t *self) {
    stop_when_due(self);
    if (is_over(self)) {
        rest_monitor_end(&self->rest, self->now_ns);
        self->latency_ms = latency_end(&self->latency, &self->observer.delays, DRIVE_SERVO_TIME_CONSTANT_S);
        return false;
    }
    const int64_t now_ns = self->now_ns, next_ns = now_ns + WORLD_TICK_NS;
    look(self);

    tracker_node_step(self->tracker, now_ns, next_ns); /* queue the frames due in this tick */
    proximity_node_step(self->proximity_sensor, &self->clearance, now_ns, next_ns);
    gripper_node_step(self->gripper, now_ns, next_ns);
    operator_node_step(self->operator, now_ns, next_ns);
    bus_run_until(self->bus, next_ns);              /* drives receive their commands and sample their encoders */
    drive_node_step(self->drives, next_ns, TICK_S); /* commands -> motors */
    move(self);

    watch(self);
    self->now_ns = next_ns;
    self->ticks++;
    if (self->on_tick != NULL) {
        self->on_tick(self->on_tick_context, self);
    }
    return true;
}

void world_free(world_t *self) {
    operator_node_destroy(self->operator);
    proximity_node_destroy(self->proximity_sensor);
    tracker_node_destroy(self->tracker);
    gripper_node_destroy(self->gripper);
    drive_node_destroy(self->drives);
    bus_destroy(self->bus);
    proximity_destroy(self->proximity);
    for (size_t i = 0; i < SCENARIO_MAX_PEOPLE; i++) {
        person_program_destroy(self->program[i]);
    }
    hand_history_destroy(self->hand_history);
    scene_destroy(self->scene);
    largest_scale_free(&self->largest_scale);
    observer_free(&self->observer);
}
