/* Replaces firmware/main.c for `make cycles`. This program processes the input.bin written by cycles.py, and encloses
 * the code to be counted in count_begin() and count_end(). For each count, it writes to output.bin one byte that says
 * what was counted (counted_t). */
#include "../../firmware/arms/hoap3_right.h"
#include "../../firmware/main.h"
#include "../bitexact/records.h"

typedef enum {
    COUNTED_NOTHING = 0,
    COUNTED_STEP,
    COUNTED_TICK,
    COUNTED_TICK_TORSO,
    COUNTED_TICK_GENERAL,
    COUNTED_TICK_LIMITS,
    COUNTED_TICK_GENERAL_LIMITS,
    COUNTED_TICK_BLEND,
    COUNTED_ESTIMATE,
    COUNTED_PREDICTION,
    COUNTED_LAW,
    COUNTED_LAW_LIMITS,
    COUNTED_STEP_NOT_PREDICTED,
    COUNTED_JOINT_WATCH
} counted_t;

/* plugin.c counts the instructions from each call of count_begin() to the next call of count_end(). */
void count_begin(void);
void count_end(void);

__attribute__((noinline)) void count_begin(void) {
    __asm__ volatile("" ::: "memory");
}

__attribute__((noinline)) void count_end(void) {
    __asm__ volatile("" ::: "memory");
}

static void report(counted_t what) {
    const uint8_t byte = (uint8_t)what;
    platform_write(&byte, 1);
}

/* These variables are static because the stack is only as large as the product needs. */
static cooperation_t cooperation;
static differential_ik_config_t config;
static hand_motion_t motion;
static position_priority_config_t position_priority_config;

/* Runs Algorithm 1, kinematics and control law (4), as the controller calls them. */
static void tick(const float position_rad[], const pose_t *hand, joints_at_limit_t at_limit, float blend,
                 counted_t what) {
    float velocity_radps[ARM_MAX_JOINTS];
    const differential_ik_request_t request = {
        .position_rad = position_rad, .target = &cooperation.target, .at_limit = at_limit};
    count_begin();
    cooperation_update(&cooperation, hand, blend);
    arm_ik_differential(&arm_ik_hoap3_right, &config, &request, velocity_radps);
    count_end();
    report(what);
}

static void ticks(const float position_rad[], const pose_t *hand) {
    const joints_at_limit_t none = {0, 0}, all = {0x5, 0xA};
    cooperation.settled = cooperation.latched = false;
    tick(position_rad, hand, none, 0.5f, COUNTED_TICK_BLEND);
    cooperation_update(&cooperation, hand, 1.0f); /* completes the change of task */
    tick(position_rad, hand, none, 1.0f, COUNTED_TICK);
    tick(position_rad, hand, all, 1.0f, COUNTED_TICK_LIMITS);
    config.error_frame = ERROR_FRAME_TORSO;
    tick(position_rad, hand, none, 1.0f, COUNTED_TICK_TORSO);
    config.error_frame = ERROR_FRAME_TARGET;
    config.weight[1] *= 2.0f;
    differential_ik_prepare(&config);
    tick(position_rad, hand, none, 1.0f, COUNTED_TICK_GENERAL);
    tick(position_rad, hand, all, 1.0f, COUNTED_TICK_GENERAL_LIMITS);
}

/* Runs the parts of a tick with prediction as the controller calls them: a new sample 4 ms after the last one, the
 * hand's and the target's motion at the time of the command, and the control law. */
static void predicted_ticks(const float position_rad[], const pose_t *sample) {
    const float ahead_s = 0.003f;
    const uint32_t captured_us = motion.captured_us + 4000u, now_us = captured_us + 4000u;
    count_begin();
    hand_motion_sample(&motion, sample, captured_us, now_us);
    count_end();
    report(COUNTED_ESTIMATE);
    count_begin();
    const pose_t hand = hand_motion_pose(&motion, now_us, -0.001f);
    const twist_t hand_moves = hand_motion_twist(&motion, now_us, ahead_s);
    const twist_t target_moves = cooperation_target_motion(&cooperation, &hand_moves);
    count_end();
    report(COUNTED_PREDICTION);
    for (int at_limits = 0; at_limits < 2; at_limits++) {
        const joints_at_limit_t at_limit = {at_limits ? 0x5 : 0, at_limits ? 0xA : 0};
        const position_priority_request_t request = {position_rad, &cooperation.target, &target_moves, at_limit};
        float feedback_radps[ARM_MAX_JOINTS], feedforward_radps[ARM_MAX_JOINTS];
        count_begin();
        cooperation_update(&cooperation, &hand, 1.0f);
        (void)arm_ik_position_priority(&arm_ik_hoap3_right, &position_priority_config, &request, feedback_radps,
                                       feedforward_radps);
        count_end();
        report(at_limits ? COUNTED_LAW_LIMITS : COUNTED_LAW);
    }
}

/* Runs the watch of the joints as the controller calls it, for the tick after the last one. */
static void watch_joints(const controller_t *controller, uint32_t now_us) {
    static joint_watch_t watch;
    joint_state_t state[ARM_MAX_JOINTS] = {{0}};
    joint_cmd_t command = {0};
    watch = controller->joint_watch;
    for (int i = 0; i < controller->arm->joint_count; i++) {
        state[i] = (joint_state_t){.position_rad = controller->measured_rad[i], .mode = DRIVE_MODE_VELOCITY};
        command.mode[i] = DRIVE_MODE_VELOCITY;
        command.velocity_radps[i] = controller->limits.velocity_radps[i];
    }
    now_us += 1000u * controller->tick_ms;
    count_begin();
    for (int i = 0; i < controller->arm->joint_count; i++) {
        joint_watch_report(&watch, i, &state[i], now_us);
    }
    (void)joint_watch_check(&watch, now_us);
    joint_watch_command(&watch, &command, true);
    count_end();
    report(COUNTED_JOINT_WATCH);
}

/* Runs the counted parts in a generated state. The end effector's initial pose follows from the joint positions. */
static void run_state(const record_t *record, const controller_t *controller) {
    struct {
        float position_rad[4];
        pose_t hand;
    } state;
    (void)platform_read(&state, sizeof state);
    cooperation = (cooperation_t){0};
    config = controller->differential_ik_config;
    cooperation_start(&cooperation, &controller->cooperation_config, &task_table[record->count], pose_identity,
                      arm_hoap3_right.forward_kinematics(&arm_hoap3_right, state.position_rad));
    position_priority_config = controller->position_priority_config;
    hand_motion_init(&motion);
    hand_motion_sample(&motion, &state.hand, 0u, 4000u);
    ticks(state.position_rad, &state.hand);
    predicted_ticks(state.position_rad, &state.hand);
    watch_joints(controller, record->now_us);
}

static void drop(void *context, const can_frame_t *frame) {
    (void)context;
    (void)frame;
}

void firmware_main(void) {
    static controller_t controller;
    static controller_inbox_t inbox;
    controller_outbox_t outbox = {.sink = {.send = drop}};
    record_t record;
    platform_open();
    count_begin();
    count_end();
    report(COUNTED_NOTHING);
    while (record_read(&record)) {
        if (record.kind == RECORD_STATE) {
            run_state(&record, &controller);
        } else if (record.kind == RECORD_TICK) {
            record_read_inbox(&record, &inbox);
            count_begin();
            controller_step(&controller, record.now_us, &inbox, &outbox);
            count_end();
            report(controller.predicts ? COUNTED_STEP : COUNTED_STEP_NOT_PREDICTED);
            if (controller.supervisor.mode == MODE_COOPERATING && controller.differential_ik_config.isotropic.applies) {
                cooperation = controller.cooperation;
                config = controller.differential_ik_config;
                position_priority_config = controller.position_priority_config;
                motion = controller.marker_motion;
                ticks(controller.measured_rad, &controller.hand);
                predicted_ticks(controller.measured_rad, hand_tracker_newest(&controller.hand_tracker));
                watch_joints(&controller, record.now_us);
            }
        } else {
            record_boot(&record, &controller);
        }
    }
    platform_close();
}
