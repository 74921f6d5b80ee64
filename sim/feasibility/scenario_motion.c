/* Checks that no program moves a hand faster or farther than a person can. */
#include <math.h>
#include <stdio.h>

#include "scenario_geometry.h"

#define SPEED_MAX_MPS 5.0
#define DISTANCE_MAX_M 1.5
#define PEAK_OF_MINIMUM_JERK 1.875 /* ratio of the peak speed to the mean speed */

/* Position of the hand relative to its start. */
typedef struct {
    bool is_known;
    double m[3];
} hand_position_t;

typedef struct {
    const scenario_t *scenario;
    const char *person, *program;
    char *error;
    size_t error_size;
} motion_t;

static double length_m(const double v[3]) {
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* Checks the speed of the hand in a step. path_m: length of the path. peak: ratio of the peak speed to the mean
 * speed. */
static bool check_speed(const motion_t *self, size_t step_index, const person_step_t *step, double path_m,
                        double peak) {
    const double speed_mps = peak * path_m / step->duration_s;
    if (speed_mps > SPEED_MAX_MPS) {
        (void)snprintf(self->error, self->error_size,
                       "%s: people.%s.%s[%zu].duration_s '%g': expected more time: on its path of %.3g m the hand "
                       "would reach %.3g m/s, above the limit of %g m/s",
                       self->scenario->path, self->person, self->program, step_index, step->duration_s, path_m,
                       speed_mps, SPEED_MAX_MPS);
        return false;
    }
    return true;
}

static bool check_distance(const motion_t *self, size_t step_index, const hand_position_t *position) {
    if (position->is_known && length_m(position->m) > DISTANCE_MAX_M) {
        (void)snprintf(self->error, self->error_size,
                       "%s: people.%s.%s[%zu] '[%g, %g, %g]': expected a position at most %g m from the start",
                       self->scenario->path, self->person, self->program, step_index, position->m[0], position->m[1],
                       position->m[2], DISTANCE_MAX_M);
        return false;
    }
    return true;
}

static bool check_move(const motion_t *self, size_t step_index, const person_step_t *step, hand_position_t *position) {
    double path_m[3];
    for (int k = 0; k < 3; k++) {
        path_m[k] = step->displacement_m[k] - (step->from_here ? 0.0 : position->m[k]);
        position->m[k] = step->displacement_m[k] + (step->from_here ? position->m[k] : 0.0);
    }
    const bool is_path_known = step->from_here || position->is_known;
    position->is_known = position->is_known || !step->from_here;
    return (!is_path_known || check_speed(self, step_index, step, length_m(path_m), PEAK_OF_MINIMUM_JERK)) &&
           check_distance(self, step_index, position);
}

static bool check_program(const motion_t *self, const person_step_t steps[], size_t count) {
    hand_position_t position = {.is_known = true};
    for (size_t i = 0; i < count; i++) {
        switch (steps[i].action) {
        case PERSON_MOVE:
            if (!check_move(self, i, &steps[i], &position)) {
                return false;
            }
            break;
        case PERSON_REACH:
        case PERSON_GUIDE:
        case PERSON_PLAY: position.is_known = false; break;
        case PERSON_TURN: {
            const double around_m = 2.0 * ROBOT_PI * self->scenario->object[steps[i].object].radius_m;
            if (!check_speed(self, i, &steps[i], around_m, 1.0)) { /* duration_s is per turn, at constant speed */
                return false;
            }
            position.is_known = false;
            break;
        }
        case PERSON_REST:
        case PERSON_GRIP:
        case PERSON_RELEASE: break;
        }
    }
    return true;
}

bool scenario_check_motion(const scenario_t *self, char error[], size_t error_size) {
    for (size_t i = 0; i < self->person_count; i++) {
        const person_t *person = &self->person[i];
        motion_t motion = {self, person->name, "program", error, error_size};
        if (!check_program(&motion, person->step, person->step_count)) {
            return false;
        }
        motion.program = "program_with_recording";
        if (!check_program(&motion, person->recorded_step, person->recorded_step_count)) {
            return false;
        }
    }
    return true;
}
