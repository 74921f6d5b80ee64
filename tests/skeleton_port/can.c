/* A stub CAN driver, because no emulated board has a CAN controller. The stub discards each frame to be sent, and
 * receives one frame for each. After a thousand JointCmd frames, it ends the emulator. */
#include "can.h"

#include "../common/tick.h"
#include "../cortex_m/drivers.h"
#include "../hal.h"
#include "board.h"
#include "semihosting.h"

#define JOINT_CMD_ID 0x050u
#define LAST_COMMAND 1000u
#define QUEUE_FRAMES 16u

static struct {
    uint32_t received_us[QUEUE_FRAMES]; /* ring of reception times */
    volatile uint32_t head, tail;
    uint32_t commands;
} can;

void can_start(void) {
    NVIC_SET_ENABLE(BOARD_CAN_INTERRUPT) = NVIC_BIT(BOARD_CAN_INTERRUPT);
}

void can_handler(void) {
    can.received_us[can.head % QUEUE_FRAMES] = clock_us();
    can.head++;
}

bool hal_can_send(const can_frame_t *frame) {
    if (frame->id == JOINT_CMD_ID && ++can.commands == LAST_COMMAND) {
        semihosting_exit(true);
    }
    NVIC_SET_PENDING(BOARD_CAN_INTERRUPT) = NVIC_BIT(BOARD_CAN_INTERRUPT);
    return true;
}

bool hal_can_receive(can_frame_t *frame) {
    if (can.tail == can.head) {
        return false;
    }
    *frame = (can_frame_t){.id = 0x7FF, .timestamp_us = can.received_us[can.tail % QUEUE_FRAMES]};
    can.tail++;
    return true;
}

/* The driver of a real controller also counts the frames that were lost because its queues were full, and reads the
 * controller's error states. */
void hal_port_status(port_status_t *status) {
    *status = (port_status_t)PORT_STATUS_UNKNOWN;
    status->refused_frames = 0;
    status->lost_frames = 0;
    tick_status(status);
}
