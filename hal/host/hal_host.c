#include "hal_host.h"

#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>

#include "../../firmware/main.h"
#include "../hal.h"

#define RECEIVE_QUEUE_FRAMES 64
#define COMPUTE_TIME_NS                                                                                                \
    50000 /* assumed, from the tick to the frames it produces: an order above what the host needs                      \
           */
#define WATCHDOG_TIMEOUT_NS 10000000

static struct {
    world_t *world;
    int node;
    can_frame_t received[RECEIVE_QUEUE_FRAMES]; /* ring */
    size_t first, count;
    int64_t fed_ns;
    jmp_buf powered_off;
} host;

static void on_frame(void *context, const can_frame_t *frame, int64_t end_ns) {
    (void)context;
    (void)end_ns; /* the frame's own timestamp is what a CAN controller gives */
    if (host.count == RECEIVE_QUEUE_FRAMES) {
        host.world->firmware_overflows++;
        return;
    }
    host.received[(host.first + host.count) % RECEIVE_QUEUE_FRAMES] = *frame;
    host.count++;
}

void hal_host_run(world_t *world) {
    host.world = world;
    if (setjmp(host.powered_off) == 0) {
        firmware_main();
    }
}

can_profile_t hal_can_profile(void) {
    return bus_profile(host.world->bus);
}

void hal_init(void) {
    host.node = bus_attach(host.world->bus, on_frame, NULL);
    host.first = 0;
    host.count = 0;
    host.fed_ns = host.world->now_ns;
    hal_enable_drives(false);
}

bool hal_wait_tick(uint32_t *now_us) {
    if (host.world->now_ns - host.fed_ns > WATCHDOG_TIMEOUT_NS) {
        hal_enable_drives(false);
        world_fail(host.world, "watchdog: not fed by the firmware for 10 ms");
    }
    const bool running = world_advance(host.world);
    *now_us = (uint32_t)(host.world->now_ns / 1000);
    return running;
}

bool hal_can_receive(can_frame_t *frame) {
    if (host.count == 0) {
        return false;
    }
    *frame = host.received[host.first];
    host.first = (host.first + 1) % RECEIVE_QUEUE_FRAMES;
    host.count--;
    return true;
}

bool hal_can_send(const can_frame_t *frame) {
    return bus_send(host.world->bus, host.node, frame, host.world->now_ns + COMPUTE_TIME_NS);
}

void hal_watchdog_feed(void) {
    host.fed_ns = host.world->now_ns;
}

void hal_enable_drives(bool enable) {
    drive_node_enable(host.world->drives, enable);
}

/* The processor halts; here the world ends. */
void hal_panic(const char *cause) {
    hal_enable_drives(false);
    char text[WORLD_TEXT_BYTES];
    (void)snprintf(text, sizeof text, "firmware panic: %s", cause);
    world_fail(host.world, text);
    longjmp(host.powered_off, 1);
}
