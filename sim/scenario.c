#include "scenario.h"

#include <string.h>

#define COUNT(array) (sizeof(array) / sizeof(array)[0])
#define LEG(seconds, ...) {.duration_s = (seconds), .displacement_m = {__VA_ARGS__}}

/* Hand frame as the robot's: z forward, x up. Face to face, the person's forward is the torso's backward. */
#define FACING_THE_ROBOT {0.70710678118654752440, 0.0, -0.70710678118654752440, 0.0}
#define BESIDE_THE_ROBOT {0.0, 0.70710678118654752440, 0.0, 0.70710678118654752440}

/* ---- pour: the person holds the glass at three spots. */
static const motion_leg_t pour_legs[] = {
    LEG(2.0, 0.0, 0.0, 0.0),
    LEG(1.0, 0.020, 0.000, 0.020), LEG(2.0, 0.020, 0.000, 0.020),
    LEG(1.0, 0.010, -0.020, 0.010), LEG(2.0, 0.010, -0.020, 0.010),
    LEG(1.0, 0.0, 0.0, 0.0), LEG(2.0, 0.0, 0.0, 0.0),
};
static const scenario_check_t pour_checks[] = {
    {CHECK_SETTLED_POSITION, "settled_at_spot_1", .from_s = 2.5, .until_s = 3.5, .limit = 3.0},
    {CHECK_TILT, "glass_tilt_at_spot_1", .from_s = 2.5, .until_s = 3.5, .limit = 30.0},
    {CHECK_SETTLED_POSITION, "settled_at_spot_2", .from_s = 5.5, .until_s = 6.5, .limit = 3.0},
    {CHECK_SETTLED_POSITION, "settled_at_spot_3", .from_s = 8.5, .until_s = 9.5, .limit = 3.0},
    {CHECK_DISPLACEMENT, "way_to_spot_2", .since_s = 3.4, .until_s = 6.4, .expected_m = {0.020, 0.0, 0.020}, .limit = 3.0},
    {CHECK_DISPLACEMENT, "way_to_spot_3", .since_s = 6.4, .until_s = 9.4, .expected_m = {-0.010, -0.020, -0.010}, .limit = 3.0},
};

/* ---- teleop: smooth moves of 30 mm, and a turn of the wrist about the forearm. */
static const motion_leg_t teleop_legs[] = {
    LEG(1.0, 0.030, 0.000, 0.000), LEG(0.5, 0.030, 0.000, 0.000),
    LEG(1.0, 0.030, 0.030, 0.000), LEG(0.5, 0.030, 0.030, 0.000),
    LEG(1.0, 0.000, 0.000, 0.030), LEG(0.5, 0.000, 0.000, 0.030),
    LEG(1.0, 0.0, 0.0, 0.0), LEG(0.5, 0.0, 0.0, 0.0),
    {.duration_s = 1.0, .rotation_vector_rad = {20.0 * ROBOT_RAD_PER_DEG, 0.0, 0.0}},
    {.duration_s = 0.5, .rotation_vector_rad = {20.0 * ROBOT_RAD_PER_DEG, 0.0, 0.0}},
    LEG(1.0, 0.0, 0.0, 0.0),
};
static const scenario_check_t teleop_checks[] = {
    {CHECK_DISPLACEMENT, "forward", .until_s = 3.4, .expected_m = {0.030, 0.0, 0.0}, .limit = 2.0},
    {CHECK_DISPLACEMENT, "forward_and_left", .until_s = 4.9, .expected_m = {0.030, 0.030, 0.0}, .limit = 2.0},
    {CHECK_DISPLACEMENT, "up", .until_s = 6.4, .expected_m = {0.0, 0.0, 0.030}, .limit = 2.0},
    {CHECK_DISPLACEMENT, "back_at_start", .until_s = 7.9, .expected_m = {0.0, 0.0, 0.0}, .limit = 2.0},
    {CHECK_TURN, "wrist_turned", .until_s = 9.4, .expected_deg = 20.0, .limit = 3.0},
    {CHECK_DISPLACEMENT, "wrist_turned_in_place", .until_s = 9.4, .expected_m = {0.0, 0.0, 0.0}, .limit = 2.0},
};

/* ---- mirror: back, sideways and up, then the grasp and a carry; the robot's x is the mirror image until the latch. */
static const motion_leg_t mirror_legs[] = {
    LEG(1.0, 0.030, 0.000, 0.000), LEG(1.0, 0.030, 0.000, 0.000),
    LEG(1.0, 0.030, 0.030, 0.000), LEG(1.0, 0.030, 0.030, 0.000),
    LEG(1.0, 0.000, 0.030, 0.030), LEG(1.0, 0.000, 0.030, 0.030),
    LEG(1.0, 0.000, 0.000, 0.000), LEG(2.0, 0.000, 0.000, 0.000),
    LEG(1.0, 0.020, 0.000, 0.000), LEG(1.0, 0.020, 0.000, 0.000),
};
static const scenario_check_t mirror_checks[] = {
    {CHECK_DISPLACEMENT, "mirrored_back", .until_s = 3.9, .expected_m = {-0.030, 0.0, 0.0}, .limit = 2.0},
    {CHECK_DISPLACEMENT, "same_side", .until_s = 5.9, .expected_m = {-0.030, 0.030, 0.0}, .limit = 2.0},
    {CHECK_DISPLACEMENT, "same_height", .until_s = 7.9, .expected_m = {0.0, 0.030, 0.030}, .limit = 2.0},
    {CHECK_DISPLACEMENT, "at_the_grasp", .until_s = 9.9, .expected_m = {0.0, 0.0, 0.0}, .limit = 2.0},
    {CHECK_DISPLACEMENT, "carried", .until_s = 12.9, .expected_m = {0.020, 0.0, 0.0}, .limit = 2.0},
};

const scenario_t scenario_table[] = {
    {
        .name = "pour", .summary = "the robot pours into the person's glass at three spots",
        .task = TASK_POUR, .start_deg = {90.0, -60.0, 0.0, -100.0},
        .command_start_s = 0.5, .motion_start_s = 2.0, .duration_s = 14.0,
        .hand_start = {{0.40, -0.20, 0.05}, FACING_THE_ROBOT},
        .legs = pour_legs, .leg_count = COUNT(pour_legs),
        .checks = pour_checks, .check_count = COUNT(pour_checks),
        .tracking_rms_limit_mm = 2.0, .tracking_max_limit_mm = 4.0, .followable_min_percent = 60.0,
    },
    {
        .name = "teleop", .summary = "the robot's hand does what the person's hand does",
        .task = TASK_TELEOP, .start_deg = {60.0, -30.0, -10.0, -80.0},
        .command_start_s = 0.5, .motion_start_s = 2.0, .duration_s = 12.0,
        .hand_start = {{0.30, 0.40, 0.05}, BESIDE_THE_ROBOT},
        .legs = teleop_legs, .leg_count = COUNT(teleop_legs),
        .checks = teleop_checks, .check_count = COUNT(teleop_checks),
        .tracking_rms_limit_mm = 1.0, .tracking_max_limit_mm = 2.5, .followable_min_percent = 60.0,
    },
    {
        .name = "mirror", .summary = "robot and person move face to face like mirror images, then carry together",
        .task = TASK_MIRROR, .start_deg = {90.0, -5.0, 0.0, -90.0},
        .command_start_s = 0.5, .motion_start_s = 2.0, .latch_s = 10.5, .duration_s = 14.0,
        .hand_start = {{0.50, -0.11, 0.05}, FACING_THE_ROBOT},
        .legs = mirror_legs, .leg_count = COUNT(mirror_legs),
        .checks = mirror_checks, .check_count = COUNT(mirror_checks),
        .tracking_rms_limit_mm = 1.0, .tracking_max_limit_mm = 2.5, .followable_min_percent = 60.0,
    },
};
const size_t scenario_count = COUNT(scenario_table);

const scenario_t *scenario_find(const char *name) {
    for (size_t i = 0; i < scenario_count; i++) {
        if (strcmp(scenario_table[i].name, name) == 0) {
            return &scenario_table[i];
        }
    }
    return NULL;
}

/* A person grasps, or takes a new reference, while the robot follows and not while it waits for the tracker. */
static size_t add_in_cooperation(operator_step_t steps[], size_t count, command_t command, double at_s, double stop_s) {
    if (at_s > 0.0 && at_s < stop_s) {
        steps[count++] = (operator_step_t){OPERATOR_AWAIT_MODE, .not_before_s = at_s, .mode = MODE_COOPERATING,
                                           .patience_s = stop_s - at_s};
        steps[count++] = (operator_step_t){OPERATOR_COMMAND, .command = command};
    }
    return count;
}

size_t scenario_script(const scenario_t *self, double duration_s, const operator_wishes_t *wishes,
                       operator_step_t steps[]) {
    const double stop_s = duration_s - SCENARIO_STOP_BEFORE_END_S;
    size_t count = 0;
    for (int i = 0; i < PARAMETER_COUNT; i++) {
        if (wishes->parameter_written[i]) {
            steps[count++] = (operator_step_t){OPERATOR_WRITE_PARAMETER, .not_before_s = 0.01,
                                               .parameter = (uint8_t)i, .value = wishes->parameter_value[i]};
        }
    }
    steps[count++] = (operator_step_t){OPERATOR_AWAIT_MODE, .mode = MODE_READY, .patience_s = 3.0};
    if (wishes->defines_task) {
        steps[count++] = (operator_step_t){OPERATOR_DEFINE_TASK, .command = COMMAND_DEFINE, .define = wishes->task};
    } else {
        steps[count++] = (operator_step_t){OPERATOR_COMMAND, .command = COMMAND_SELECT, .task = self->task};
    }
    steps[count++] = (operator_step_t){OPERATOR_COMMAND, .not_before_s = self->command_start_s,
                                       .command = COMMAND_START};
    const bool clutch_first = wishes->clutch_s <= self->latch_s;
    if (clutch_first) {
        count = add_in_cooperation(steps, count, COMMAND_CLUTCH, wishes->clutch_s, stop_s);
    }
    count = add_in_cooperation(steps, count, COMMAND_LATCH, self->latch_s, stop_s);
    if (!clutch_first) {
        count = add_in_cooperation(steps, count, COMMAND_CLUTCH, wishes->clutch_s, stop_s);
    }
    steps[count++] = (operator_step_t){OPERATOR_COMMAND, .not_before_s = stop_s, .command = COMMAND_STOP};
    steps[count++] = (operator_step_t){OPERATOR_AWAIT_MODE, .mode = MODE_READY,
                                       .patience_s = 0.8 * SCENARIO_STOP_BEFORE_END_S};
    return count;
}
