#include "port.h"

#include <inttypes.h>
#include <signal.h>
#include <stdio.h>
#include <unistd.h>

#include "../../firmware/protocol/can_transport.h"
#include "../hal.h"
#include "can_socket.h"
#include "hardware_clock.h"
#include "pace.h"
#include "store.h"
#include "watchdog.h"

#define PROGRAM "comanip-firmware"
#define PRIORITY 80       /* higher than that of the plant and other programs */
#define REPORT_TICKS 1000 /* overruns are reported at most once a second */
#define EXIT_PANIC 1

static struct {
    can_profile_t profile;
    can_socket_t can;
    pace_t pace;
    uint64_t ticks;
    uint64_t reported_overruns;
    hardware_clock_t hardware_clock;
    bool has_reported_stamps;
    int64_t empty_ns; /* time of the last tick at which the receive queue was empty */
} port;

static volatile sig_atomic_t stopped;

static void on_stop(int signal_number) {
    (void)signal_number;
    stopped = 1;
}

bool port_open(const char *can, can_profile_t profile, uint32_t slow, const char *parameters, char error[],
               size_t error_size) {
    if (parameters != NULL && !store_open(PROGRAM, parameters, error, error_size)) {
        return false;
    }
    uint16_t ids[TRANSPORT_MAX_IDS];
    const can_selection_t selection = {
        .ids = ids, .count = transport_ids_to_firmware(profile, ids), .classic = profile == CAN_PROFILE_CLASSIC};
    port.profile = profile;
    if (!can_socket_open(&port.can, PROGRAM, can, &selection, error, error_size)) {
        return false;
    }
    pace_init(&port.pace, slow);
    return true;
}

void hal_init(void) {
    const struct sigaction action = {.sa_handler = on_stop};
    (void)sigaction(SIGINT, &action, NULL);
    (void)sigaction(SIGTERM, &action, NULL);
    store_start(); /* before this thread gets its real-time priority, which the store's thread would inherit */
    pace_make_real_time(PROGRAM, PRIORITY);
    watchdog_start(PACE_TICK_NS * port.pace.slow, PRIORITY + 1);
    pace_init(&port.pace, (uint32_t)port.pace.slow); /* so that the start-up does not count as overruns */
    port.empty_ns = port.pace.tick_ns;
}

can_profile_t hal_can_profile(void) {
    return port.profile;
}

static void report_clock(void) {
    if (pace_find_step(&port.pace)) {
        (void)fprintf(stderr, PROGRAM ": the system's clock was set: %+.3f s relative to the start\n",
                      1e-9 * (double)port.pace.step_ns);
    }
    if (port.ticks % REPORT_TICKS == 0 && port.pace.overruns != port.reported_overruns) {
        (void)fprintf(stderr, PROGRAM ": %" PRIu64 " ticks missed, %" PRIu64 " in all\n",
                      port.pace.overruns - port.reported_overruns, port.pace.overruns);
        port.reported_overruns = port.pace.overruns;
    }
}

bool hal_wait_tick(uint32_t *now_us) {
    bool waiting = true;
    while (stopped == 0 && waiting) {
        waiting = !pace_wait_tick(&port.pace); /* wait again after a signal that does not end the process */
    }
    port.ticks += !waiting; /* a wait ended by a signal does not count as a tick */
    report_clock();
    *now_us = pace_clock_us(&port.pace, port.pace.tick_ns);
    return stopped == 0;
}

/* A hub provides no timestamps. A frame is then stamped with the earliest time at which it can have arrived, so that
 * it does not look fresher than it is. */
static int64_t time_of_reception_ns(const can_reception_t *reception) {
    if (reception->unix_ns == 0) {
        return port.empty_ns;
    }
    const int64_t kernel_ns = pace_stamp_unix_ns(&port.pace, reception->unix_ns);
    return reception->hardware_ns == 0 ? kernel_ns
                                       : hardware_clock_map(&port.hardware_clock, reception->hardware_ns, kernel_ns);
}

/* Reports the kind of timestamp once, at the first frame, because it does not change. */
static void report_stamps(const can_reception_t *reception) {
    if (!port.has_reported_stamps) {
        port.has_reported_stamps = true;
        (void)printf(PROGRAM ": times of reception: %s\n", reception->hardware_ns != 0 ? "the CAN controller's"
                                                           : reception->unix_ns != 0
                                                               ? "the kernel's, since the CAN controller gives none"
                                                               : "estimated from the ticks, since a hub gives none");
        (void)fflush(stdout);
    }
}

bool hal_can_receive(can_frame_t *frame) {
    can_reception_t reception;
    if (!can_socket_receive(&port.can, frame, &reception)) {
        port.empty_ns = port.pace.tick_ns;
        return false;
    }
    report_stamps(&reception);
    frame->timestamp_us = pace_clock_us(&port.pace, time_of_reception_ns(&reception));
    return true;
}

bool hal_can_send(const can_frame_t *frame) {
    return can_socket_send(&port.can, frame);
}

void hal_port_status(port_status_t *status) {
    *status = (port_status_t)PORT_STATUS_UNKNOWN;
    can_socket_status(&port.can, status);
    status->missed_ticks = port_count(port.pace.overruns);
    status->longest_tick_us = port_count((uint64_t)port.pace.longest_ns / 1000);
}

void hal_watchdog_feed(void) {
    watchdog_feed();
}

/* Does nothing, because a process has no enable line. */
void hal_enable_drives(bool enable) {
    (void)enable;
}

/* There is no power to cut. The commands end with the process, and the drives brake when their own timeout expires. */
_Noreturn void hal_panic(const char *cause) {
    (void)fprintf(stderr, PROGRAM ": panic: %s\n", cause);
    _exit(EXIT_PANIC);
}

void port_close(void) {
    can_socket_report(&port.can);
    (void)printf(PROGRAM ": stopped after %" PRIu64 " ticks, %" PRIu64 " missed; %" PRIu64 " frames received, %" PRIu64
                         " sent\n",
                 port.ticks, port.pace.overruns, port.can.counters.received, port.can.counters.sent);
    can_socket_close(&port.can);
}
