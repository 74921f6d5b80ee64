#include "local_firmware.h"

#include <setjmp.h>
#include <stdio.h>

#include "../../firmware/main.h"
#include "../../hal/hal.h"
#include "firmware_node.h"

#define WATCHDOG_TIMEOUT_NS 10000000

static struct {
    world_t *world;
    firmware_node_t node;
    int64_t fed_ns;
    jmp_buf powered_off;
} local;

void local_firmware_run(world_t *world) {
    local.world = world;
    if (setjmp(local.powered_off) == 0) {
        firmware_main();
    }
}

can_profile_t hal_can_profile(void) {
    return bus_profile(local.world->bus);
}

void hal_init(void) {
    firmware_node_attach(&local.node, local.world);
    local.fed_ns = local.world->now_ns;
    hal_enable_drives(false);
}

bool hal_wait_tick(uint32_t *now_us) {
    if (local.world->now_ns - local.fed_ns > WATCHDOG_TIMEOUT_NS) {
        hal_enable_drives(false);
        world_fail(local.world, "watchdog: not fed by the firmware for 10 ms");
    }
    const bool running = world_advance(local.world);
    *now_us = (uint32_t)(local.world->now_ns / 1000);
    return running;
}

bool hal_can_receive(can_frame_t *frame) {
    return firmware_node_receive(&local.node, frame);
}

bool hal_can_send(const can_frame_t *frame) {
    return firmware_node_send(&local.node, frame);
}

/* The simulated bus has no errors, and no tick is ever missed, because simulated time waits for the firmware. */
void hal_port_status(port_status_t *status) {
    *status = (port_status_t)PORT_STATUS_UNKNOWN;
    status->refused_frames = port_count(local.node.refused_frames);
    status->lost_frames = port_count(local.node.world->firmware_overflows);
    status->missed_ticks = 0;
}

void hal_watchdog_feed(void) {
    local.fed_ns = local.world->now_ns;
}

void hal_enable_drives(bool enable) {
    drive_node_enable(local.world->drives, enable);
}

/* Fails the run. On real hardware, hal_panic() halts the processor instead. */
void hal_panic(const char *cause) {
    hal_enable_drives(false);
    char text[WORLD_TEXT_BYTES];
    (void)snprintf(text, sizeof text, "firmware panic: %s", cause);
    world_fail(local.world, text);
    longjmp(local.powered_off, 1);
}
