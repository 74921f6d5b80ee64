#include "measurement.h"

#include <math.h>

#include "../common/rigid_pose.h"
#include "measure.h"
#include "tracking.h"

#define MM_PER_M 1e3

static double tilt_deg(const rigid_pose_t *pose, const double axis[3]) {
    double tilted[3];
    rotation_apply(pose->rotation, axis, tilted);
    return atan2(hypot(tilted[0], tilted[1]), tilted[2]) / ROBOT_RAD_PER_DEG;
}

/* Returns the tilt of the end effector axis that pointed up at the start. */
static double hand_tilt_deg(const rigid_pose_t *start, const rigid_pose_t *now) {
    const double up[3] = {0.0, 0.0, 1.0};
    const double from_torso[4] = {start->rotation[0], -start->rotation[1], -start->rotation[2], -start->rotation[3]};
    double axis[3];
    rotation_apply(from_torso, up, axis);
    return tilt_deg(now, axis);
}

static double displacement_error_mm(const rigid_pose_t *begin, const rigid_pose_t *now, const double expected_m[3],
                                    double motion_scale) {
    double square = 0.0;
    for (int k = 0; k < 3; k++) {
        const double error_m = now->position_m[k] - begin->position_m[k] - motion_scale * expected_m[k];
        square += error_m * error_m;
    }
    return MM_PER_M * sqrt(square);
}

static double turn_deg(const rigid_pose_t *a, const rigid_pose_t *b) {
    return rotation_angle_between(a->rotation, b->rotation) / ROBOT_RAD_PER_DEG;
}

static double displacement_along_mm(const measurement_t *self, const tick_record_t *tick, int axis) {
    return MM_PER_M * (tick->hand.position_m[axis] - self->begin_hand.position_m[axis]);
}

/* ---- accumulation */

static void keep_last(measurement_t *self, double value) {
    self->value = value;
    self->ticks++;
}

/* Unlike fmax(), keeps NaN once it occurs, so that the check fails if the physics diverges. */
static void keep_largest(measurement_t *self, double value) {
    if (self->ticks == 0 || (!isnan(self->value) && !(value <= self->value))) {
        self->value = value;
    }
    self->ticks++;
}

static void keep_least(measurement_t *self, double value) {
    if (self->ticks == 0 || (!isnan(self->value) && !(value >= self->value))) {
        self->value = value;
    }
    self->ticks++;
}

static void add(measurement_t *self, double value) {
    self->value += value;
    self->ticks++;
}

static void add_square(measurement_t *self, double value) {
    self->square += value * value;
    self->ticks++;
}

static double held_alone(const physical_state_t *state, size_t person, size_t object) {
    for (size_t i = 0; i <= SCENARIO_MAX_PEOPLE; i++) {
        if (state->holds[i][object] != (i == person)) {
            return 0.0;
        }
    }
    return 1.0;
}

static void add_following(measurement_t *self, const tick_record_t *tick) {
    const double orientation_deg = turn_deg(&tick->hand_at_target, &tick->target);
    add_square(self, tracking_distance_mm(tick));
    self->square_orientation_deg2 += orientation_deg * orientation_deg;
}

/* Returns the distance of the end effector from the position to which the person's displacement since the start of the
 * window should have moved it. */
static double relation_error_mm(const measurement_t *self, const rigid_pose_t *person,
                                const measurement_input_t *input) {
    double person_m[3];
    for (int k = 0; k < 3; k++) {
        person_m[k] = person->position_m[k] - self->begin_person.position_m[k];
    }
    return displacement_error_mm(&self->begin_hand, &input->tick->hand, person_m, input->motion_scale);
}

/* Averages the error vector, so that neither lag nor noise affects the result. */
static void add_aim(measurement_t *self, const scenario_check_t *check, const measurement_input_t *input) {
    const double *robot_m = input->tick->hand.position_m, *person_m = input->state->hand[check->person].position_m;
    double square = 0.0;
    self->ticks++;
    for (int k = 0; k < 3; k++) {
        self->off_m[k] += robot_m[k] - person_m[k] - check->expected_m[k];
        square += pow(self->off_m[k] / (double)self->ticks, 2.0);
    }
    self->value = MM_PER_M * sqrt(square);
}

static void measure_hand(measurement_t *self, const scenario_check_t *check, const measurement_input_t *input) {
    const tick_record_t *tick = input->tick;
    if (measure_needs_target(check->measure) && !tick->has_target) {
        return;
    }
    switch (check->measure) {
    case MEASURE_SETTLED_POSITION: keep_largest(self, tracking_distance_mm(tick)); break;
    case MEASURE_FOLLOWING_RMS: add_following(self, tick); break;
    case MEASURE_RELATION_RMS:
        add_square(self, relation_error_mm(self, &input->state->hand[check->person], input));
        break;
    case MEASURE_DISPLACEMENT:
        keep_last(self, displacement_error_mm(&self->begin_hand, &tick->hand, check->expected_m, input->motion_scale));
        break;
    case MEASURE_WAY_X: keep_last(self, displacement_along_mm(self, tick, 0)); break;
    case MEASURE_WAY_Y: keep_last(self, displacement_along_mm(self, tick, 1)); break;
    case MEASURE_WAY_Z: keep_last(self, displacement_along_mm(self, tick, 2)); break;
    case MEASURE_TILT:
        if (input->start != NULL) {
            keep_least(self, hand_tilt_deg(input->start, &tick->hand));
        }
        break;
    case MEASURE_AIM: add_aim(self, check, input); break;
    case MEASURE_TURN: keep_last(self, fabs(turn_deg(&self->begin_hand, &tick->hand) - check->expected_deg)); break;
    default: break;
    }
}

static void measure_water(measurement_t *self, const scenario_check_t *check, const measurement_input_t *input) {
    static const double along_z[3] = {0.0, 0.0, 1.0};
    const physical_state_t *state = input->state;
    const water_count_t *water = &state->water;
    if (check->measure == MEASURE_CUP_TILT_PEAK && state->has_robot_cup) {
        keep_largest(self, tilt_deg(&state->robot_cup, along_z));
    }
    if (!state->has_water) {
        return;
    }
    if (check->measure == MEASURE_WATER_POURED) {
        keep_last(self, 100.0 * (water->left_robot_cup - self->begin_left_cup) / input->particles);
    } else if (check->measure == MEASURE_WATER_CAUGHT && water->left_robot_cup > 0) {
        keep_last(self, 100.0 * water->in_person_cup / water->left_robot_cup);
    } else if (check->measure == MEASURE_FLOW_WHILE_MOVING) {
        add(self, input->is_moving[check->person] ? input->newly_left_cup : 0.0);
    }
}

static void measure_contact(measurement_t *self, const scenario_check_t *check, const measurement_input_t *input) {
    const physical_state_t *state = input->state;
    const bool holds = state->holds[check->person][check->object];
    switch (check->measure) {
    case MEASURE_DROPS: add(self, (double)(input->lost[check->object] + input->dropped[check->object])); break;
    case MEASURE_HELD: keep_last(self, held_alone(state, check->person, check->object)); break;
    case MEASURE_FORCE_RMS:
        if (holds) {
            add_square(self, physical_state_force_N(state, check->person));
        }
        break;
    case MEASURE_FORCE_PEAK:
        if (holds) {
            keep_largest(self, physical_state_force_N(state, check->person));
        }
        break;
    case MEASURE_TURNS: keep_last(self, state->crank_turns[check->object] - self->begin_turns); break;
    case MEASURE_CARRIED_FOR:
        add(self, holds && state->holds[SCENE_HOLDER_ROBOT][check->object] ? CHECK_WINDOW_TICK_S : 0.0);
        break;
    case MEASURE_CLEARANCE: keep_least(self, MM_PER_M * state->clearance.person_m); break;
    case MEASURE_SELF_CLEARANCE: keep_least(self, MM_PER_M * state->clearance.self_m); break;
    default: break;
    }
}

void measurement_sample(measurement_t *self, const scenario_check_t *check, const measurement_input_t *input) {
    const double t_s = (double)input->tick->time_ns * 1e-9;
    if (!check_window_contains(&self->window, check, t_s, input->tick->mode, input->events)) {
        return;
    }
    if (self->window.ticks == 1) {
        self->begin_hand = input->tick->hand;
        self->begin_person = input->state->hand[check->person];
        self->begin_left_cup = input->state->water.left_robot_cup;
        self->begin_turns = input->state->crank_turns[check->object];
    }
    measure_hand(self, check, input);
    measure_water(self, check, input);
    measure_contact(self, check, input);
}

bool measurement_is_valid(const measurement_t *self, const scenario_check_t *check) {
    const bool is_enough = !measure_needs_target(check->measure) || 2 * self->ticks >= self->window.ticks;
    return self->ticks > 0 && is_enough && check_window_is_whole(&self->window, check);
}

double measurement_value(const measurement_t *self, const scenario_check_t *check) {
    const bool is_rms = check->measure == MEASURE_FOLLOWING_RMS || check->measure == MEASURE_RELATION_RMS ||
                        check->measure == MEASURE_FORCE_RMS;
    return is_rms ? sqrt(self->square / (double)self->ticks) : self->value;
}

double measurement_orientation_rest_deg(const measurement_t *self, const scenario_check_t *check) {
    const bool is_following = check->measure == MEASURE_FOLLOWING_RMS;
    return is_following ? sqrt(self->square_orientation_deg2 / (double)self->ticks) : (double)NAN;
}
