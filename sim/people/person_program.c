#include "person_program.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "../hand/minimum_jerk.h"
#include "../hand/tremor.h"
#include "../scenario/forbidden_drop.h"
#include "../scenario/step_wait.h"
#include "approach.h"
#include "crank_turn.h"
#include "playlist.h"
#include "sight.h"

#define TEXT_BYTES 1024
#define GRIP_TIMEOUT_S 0.3
#define ROBOT_GAIN_MIN 1e-3 /* with a smaller gain (m per m), the hand would have to move too far to guide the robot */
#define TIME_TOLERANCE_S 1e-9

struct person_program {
    const scenario_t *scenario;
    const person_t *person;
    size_t index;
    scene_t *scene;
    events_t *events;
    const person_step_t *steps;
    size_t count;
    size_t current;
    double ready_s;        /* end of the previous step */
    bool begun;            /* the current step has begun */
    double begin_s, end_s; /* start and end of the current step; the end is known in advance only for a timed step */
    rigid_pose_t aim;      /* desired pose of the hand, without tremor */
    hand_path_t path;
    approach_t approach;
    crank_turn_t turn;
    playlist_t playlist;
    tremor_t tremor;
    bool hidden;
    char failure[TEXT_BYTES];
};

person_program_t *person_program_create(const scenario_t *scenario, size_t person, scene_t *scene, events_t *events,
                                        const char *recording, const char *axes, uint64_t seed, char error[],
                                        size_t error_size) {
    person_program_t *self = calloc(1, sizeof *self);
    if (self == NULL) {
        (void)snprintf(error, error_size, "not enough memory for the person's program");
        return NULL;
    }
    self->scenario = scenario;
    self->person = &scenario->person[person];
    self->index = person;
    self->scene = scene;
    self->events = events;
    self->steps = recording != NULL ? self->person->recorded_step : self->person->step;
    self->count = recording != NULL ? self->person->recorded_step_count : self->person->step_count;
    self->aim = self->person->start;
    tremor_init(&self->tremor, 1e-3 * self->person->tremor_mm, seed, self->person->name);
    if (recording != NULL && self->count == 0) {
        (void)snprintf(error, error_size, "%s: %s of scenario %s has no program_with_recording to play it", recording,
                       self->person->name, scenario->name);
        person_program_destroy(self);
        return NULL;
    }
    if (!playlist_open(&self->playlist, self->person->name, self->steps, self->count, recording, axes, error,
                       error_size)) {
        person_program_destroy(self);
        return NULL;
    }
    if (self->count == 0) {
        events_raise(events, self->person->done_event, 0.0);
    }
    return self;
}

void person_program_destroy(person_program_t *self) {
    if (self != NULL) {
        playlist_close(&self->playlist);
        free(self);
    }
}

/* ---- steps */

__attribute__((format(printf, 2, 3))) static void fail(person_program_t *self, const char *format, ...) {
    const int length = snprintf(self->failure, sizeof self->failure, "%s: ", self->person->name);
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(self->failure + length, sizeof self->failure - (size_t)length, format, arguments);
    va_end(arguments);
}

static void begin_move(person_program_t *self, const person_step_t *step) {
    const rigid_pose_t *base = step->from_here ? &self->aim : &self->person->start;
    rigid_pose_t goal;
    double turn[4];
    rotation_from_vector(step->rotation_vector_rad, turn);
    rotation_multiply(turn, base->rotation, goal.rotation);
    for (int i = 0; i < 3; i++) {
        goal.position_m[i] = base->position_m[i] + step->displacement_m[i];
    }
    hand_path_init(&self->path, &self->aim, &goal, NULL, self->begin_s, step->duration_s);
    self->end_s = self->begin_s + step->duration_s;
}

static void begin_approach(person_program_t *self, const person_step_t *step, const double robot_gain[3]) {
    for (int i = 0; i < 3 && step->action == PERSON_GUIDE; i++) {
        if (!(fabs(robot_gain[i]) >= ROBOT_GAIN_MIN)) {
            fail(self, "cannot guide the robot: along %c it moves %g m per m of the hand, expected at least %g m",
                 "xyz"[i], robot_gain[i], ROBOT_GAIN_MIN);
            return;
        }
    }
    self->approach = (approach_t){.step = step, .person = self->index, .scene = self->scene};
    approach_begin(&self->approach, &self->aim, robot_gain, self->begin_s);
}

static void begin_turn(person_program_t *self, const person_step_t *step) {
    const object_t *crank = &self->scenario->object[step->object];
    self->turn = (crank_turn_t){.hinge = crank->pose,
                                .radius_m = crank->radius_m,
                                .turns = step->turns,
                                .turn_s = step->duration_s,
                                .begin_s = self->begin_s,
                                .start_rad = sight_crank_rad(self->scene, step->object),
                                .here = self->aim};
    self->end_s = self->begin_s + crank_turn_duration_s(&self->turn);
}

/* Begins the current step if it is due. Returns true if it has begun. */
static bool begin(person_program_t *self, double now_s, const double robot_gain[3]) {
    const person_step_t *step = &self->steps[self->current];
    if (!step_wait_begin_s(&step->start, self->events, self->ready_s, &self->begin_s)) {
        char waited[TEXT_BYTES / 2];
        if (step_wait_timed_out(&step->start, self->events, self->ready_s, now_s, waited, sizeof waited)) {
            fail(self, "%s", waited);
        }
        return false;
    }
    if (self->begin_s > now_s + TIME_TOLERANCE_S) {
        return false;
    }
    self->end_s = self->begin_s;
    switch (step->action) {
    case PERSON_REST: self->end_s += step->duration_s; break;
    case PERSON_MOVE: begin_move(self, step); break;
    case PERSON_REACH:
    case PERSON_GUIDE: begin_approach(self, step, robot_gain); break;
    case PERSON_PLAY:
        playback_begin(&self->playlist.playback[self->current], self->begin_s, &self->aim);
        self->end_s += playback_duration_s(&self->playlist.playback[self->current]);
        break;
    case PERSON_GRIP:
    case PERSON_RELEASE: break;
    case PERSON_TURN: begin_turn(self, step); break;
    }
    self->begun = self->failure[0] == '\0';
    return self->begun;
}

static bool has_fallen(const person_program_t *self, const point_t *point) {
    return point->kind == POINT_OBJECT && forbidden_drop(self->scenario, self->events, point->index) != NULL;
}

static void fail_to_bring(person_program_t *self, const point_t *what, const char *why) {
    const point_t *to = &self->steps[self->current].to;
    char what_name[TEXT_BYTES / 4], to_name[TEXT_BYTES / 4];
    sight_name(self->scenario, what, what_name, sizeof what_name);
    sight_name(self->scenario, to, to_name, sizeof to_name);
    fail(self, "cannot bring %s to %s: %s", what_name, to_name, why);
}

/* Returns true if the moved point has reached its goal. Fails the program if the point or its goal is on an object that
 * has fallen, because a person does not follow a falling object. */
static bool is_there(person_program_t *self, double now_s, const double robot_gain[3]) {
    const person_step_t *step = &self->steps[self->current];
    const point_t own_grip = {.kind = POINT_PERSON_GRIP, .index = self->index};
    const point_t *what = step->action == PERSON_GUIDE ? &step->what : &own_grip;
    self->end_s = now_s;
    if (has_fallen(self, what) || has_fallen(self, &step->to)) {
        fail_to_bring(self, what, "it has fallen");
        return false;
    }
    double miss_m;
    const approach_status_t status = approach_update(&self->approach, robot_gain, now_s, &miss_m);
    if (status == APPROACH_FAILED) {
        char why[TEXT_BYTES / 4];
        (void)snprintf(why, sizeof why, "%.1f mm off after %d corrections, expected at most %g mm", 1e3 * miss_m,
                       self->approach.corrections, 1e3 * step->tolerance_m);
        fail_to_bring(self, what, why);
    }
    return status == APPROACH_THERE;
}

static bool has_gripped(person_program_t *self, double now_s) {
    const size_t object = self->steps[self->current].object;
    self->end_s = now_s;
    if (scene_close_hand(self->scene, self->index, object)) {
        return true;
    }
    if (now_s - self->begin_s < GRIP_TIMEOUT_S) {
        return false;
    }
    const char *name = self->scenario->object[object].name;
    for (size_t i = 0; i < self->scenario->object_count; i++) {
        if (scene_holds(self->scene, self->index, i)) {
            fail(self, "cannot grip %s: the hand already holds %s", name, self->scenario->object[i].name);
            return false;
        }
    }
    fail(self, "cannot grip %s: it is %.0f mm away", name,
         1e3 * sight_distance_m(self->scene, self->scenario, self->index, object));
    return false;
}

static bool is_over(person_program_t *self, double now_s, const double robot_gain[3]) {
    switch (self->steps[self->current].action) {
    case PERSON_REACH:
    case PERSON_GUIDE: return is_there(self, now_s, robot_gain);
    case PERSON_GRIP: return has_gripped(self, now_s);
    case PERSON_RELEASE: scene_open_hand(self->scene, self->index); return true;
    default: return now_s >= self->end_s - TIME_TOLERANCE_S;
    }
}

static void finish(person_program_t *self) {
    const person_step_t *step = &self->steps[self->current];
    if (step->name[0] != '\0') {
        char name[EVENT_NAME_BYTES + 1];
        (void)snprintf(name, sizeof name, "%s.%s", self->person->name, step->name);
        events_raise(self->events, events_find(self->events, name), self->end_s);
    }
    self->ready_s = self->end_s;
    self->begun = false;
    self->current++;
    if (self->current == self->count) {
        events_raise(self->events, self->person->done_event, self->end_s);
    }
}

/* Begins the current step if it is due, and finishes it if it is over. Returns true if it is finished. */
static bool advance(person_program_t *self, double now_s, const double robot_gain[3]) {
    if (self->failure[0] != '\0' || self->current == self->count) {
        return false;
    }
    if ((!self->begun && !begin(self, now_s, robot_gain)) || !is_over(self, now_s, robot_gain)) {
        return false;
    }
    finish(self);
    return true;
}

static void move_aim(person_program_t *self, double until_s) {
    self->hidden = false;
    if (!self->begun) {
        return;
    }
    const playback_t *playback = &self->playlist.playback[self->current];
    switch (self->steps[self->current].action) {
    case PERSON_MOVE: hand_path_sample(&self->path, until_s, &self->aim); break;
    case PERSON_REACH:
    case PERSON_GUIDE: hand_path_sample(&self->approach.path, until_s, &self->aim); break;
    case PERSON_PLAY: self->hidden = !playback_sample(playback, until_s, &self->aim); break;
    case PERSON_TURN: crank_turn_sample(&self->turn, until_s, &self->aim); break;
    case PERSON_REST:
    case PERSON_GRIP:
    case PERSON_RELEASE: break;
    }
}

void person_program_step(person_program_t *self, double now_s, double until_s, const double robot_gain[3]) {
    while (advance(self, now_s, robot_gain)) {
    }
    move_aim(self, until_s);
    rigid_pose_t hand = self->aim;
    double tremor_m[3];
    tremor_sample(&self->tremor, until_s, tremor_m);
    for (int i = 0; i < 3; i++) {
        hand.position_m[i] += tremor_m[i];
    }
    scene_aim_hand(self->scene, self->index, &hand);
}

/* ---- state */

bool person_program_is_done(const person_program_t *self) {
    return self->current == self->count;
}

bool person_program_plays(const person_program_t *self) {
    return self->begun && self->steps[self->current].action == PERSON_PLAY;
}

rigid_pose_t person_program_aim(const person_program_t *self) {
    return self->aim;
}

bool person_program_is_hidden(const person_program_t *self) {
    return self->hidden;
}

void person_program_describe(const person_program_t *self, char text[], size_t size) {
    const char *name = self->person->name;
    if (self->current == self->count) {
        (void)snprintf(text, size, "%s is done", name);
        return;
    }
    const char *missing = step_wait_missing(&self->steps[self->current].start, self->events);
    if (!self->begun && missing != NULL) {
        (void)snprintf(text, size, "%s waits for %s", name, missing);
    } else {
        (void)snprintf(text, size, "%s is at step %zu of %zu", name, self->current + 1, self->count);
    }
}

const char *person_program_failure(const person_program_t *self) {
    return self->failure[0] == '\0' ? NULL : self->failure;
}

const char *person_program_description(const person_program_t *self) {
    return self->playlist.description;
}
