/* In the place of firmware/main.c: runs what cycles.py has written to input.bin, and marks what is to be counted. After each mark
 * output.bin gets a byte that says what it was. */
#include "../../firmware/arms/hoap3_right.h"
#include "../../firmware/controller.h"
#include "../../firmware/main.h"
#include "../bitexact/platform.h"

typedef enum { RECORD_TICK = 0, RECORD_BOOT_FD = 1, RECORD_BOOT_CLASSIC = 2, RECORD_STATE = 3 } record_kind_t;

typedef enum { COUNTED_NOTHING = 0, COUNTED_STEP, COUNTED_TICK, COUNTED_TICK_TORSO, COUNTED_TICK_GENERAL, COUNTED_RECORD_END } counted_t;

/* A way from a call of count_begin() to the next of count_end() is counted: see plugin.c. */
void count_begin(void);
void count_end(void);

__attribute__((noinline)) void count_begin(void) {
    __asm__ volatile("" ::: "memory");
}

__attribute__((noinline)) void count_end(void) {
    __asm__ volatile("" ::: "memory");
}

static void told(counted_t what) {
    const uint8_t byte = (uint8_t)what;
    platform_write(&byte, 1);
}

static uint32_t word(const uint8_t bytes[4]) {
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

static bool read_frame(can_frame_t *frame) {
    uint8_t head[8]; /* stamp, id, length, FD */
    if (!platform_read(head, sizeof head)) {
        return false;
    }
    *frame = (can_frame_t){.timestamp_us = word(head), .id = (uint16_t)(head[4] | head[5] << 8), .length = head[6],
                           .fd = head[7] != 0};
    return platform_read(frame->data, frame->length);
}

/* Algorithm 1, kinematics and law (4), as the controller calls them. */
static void tick(cooperation_t *cooperation, const velocity_control_config_t *config, const float position_rad[],
                 const pose_t *hand, counted_t what) {
    float velocity_radps[ARM_MAX_JOINTS];
    const velocity_request_t request = {.position_rad = position_rad, .target = &cooperation->target};
    count_begin();
    cooperation_update(cooperation, hand, 1.0f);
    velocity_control(&arm_hoap3_right, config, &request, velocity_radps);
    count_end();
    told(what);
}

static void ticks(cooperation_t cooperation, velocity_control_config_t config, const float position_rad[],
                  const pose_t *hand) {
    cooperation_update(&cooperation, hand, 1.0f); /* what changed the task has been folded in */
    tick(&cooperation, &config, position_rad, hand, COUNTED_TICK);
    config.error_frame = ERROR_FRAME_TORSO;
    tick(&cooperation, &config, position_rad, hand, COUNTED_TICK_TORSO);
    config.error_frame = ERROR_FRAME_TARGET;
    config.weight[1] *= 2.0f;
    velocity_control_prepare(&config);
    tick(&cooperation, &config, position_rad, hand, COUNTED_TICK_GENERAL);
}

void firmware_main(void) {
    static controller_t controller;
    static controller_inbox_t inbox;
    static controller_outbox_t outbox;
    uint8_t head[6]; /* time of the tick, kind, number of frames */
    platform_open();
    count_begin();
    count_end();
    told(COUNTED_NOTHING);
    while (platform_read(head, sizeof head)) {
        if (head[4] == RECORD_STATE) { /* joints' positions, the hand */
            struct {
                float position_rad[4];
                pose_t hand;
            } state;
            (void)platform_read(&state, sizeof state);
            cooperation_t cooperation = {0};
            const pose_t start = {quaternion_identity, {0.0f, 0.0f, 0.0f}};
            cooperation_start(&cooperation, &controller.cooperation_config, &task_table[head[5] % TASK_BUILT_IN_COUNT], start,
                              arm_forward_kinematics(&arm_hoap3_right, state.position_rad));
            ticks(cooperation, controller.velocity_control_config, state.position_rad, &state.hand);
        } else if (head[4] != RECORD_TICK) {
            controller_init(&controller, &arm_hoap3_right,
                            head[4] == RECORD_BOOT_FD ? CAN_PROFILE_FD : CAN_PROFILE_CLASSIC);
        } else {
            for (inbox.count = 0; inbox.count < head[5] && read_frame(&inbox.frame[inbox.count]); inbox.count++) {
            }
            count_begin();
            controller_step(&controller, word(head), &inbox, &outbox);
            count_end();
            told(COUNTED_STEP);
            if (controller.supervisor.mode == MODE_COOPERATING && controller.velocity_control_config.isotropic.applies) {
                ticks(controller.cooperation, controller.velocity_control_config, controller.joints.position_rad,
                      &controller.hand);
            }
        }
        told(COUNTED_RECORD_END);
    }
    platform_close();
}
