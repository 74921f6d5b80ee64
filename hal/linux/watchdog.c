#include "watchdog.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stddef.h>
#include <time.h>

#include "../hal.h"

#define LOOKS_MAX 10

static atomic_uint feeds;
static struct timespec look;
static int own_priority;

static void *watch(void *unused) {
    (void)unused;
    const struct sched_param parameters = {.sched_priority = own_priority};
    (void)pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters); /* if permitted, as for the loop */
    unsigned last = atomic_load(&feeds);
    int hungry_looks = 0;
    for (;;) {
        (void)clock_nanosleep(CLOCK_MONOTONIC, 0, &look, NULL);
        const unsigned now = atomic_load(&feeds);
        hungry_looks = now == last && now != 0 ? hungry_looks + 1 : 0;
        last = now;
        if (hungry_looks == LOOKS_MAX) {
            hal_panic("watchdog: not fed by the firmware for 10 ticks");
        }
    }
    return NULL;
}

void watchdog_start(int64_t look_ns, int priority) {
    pthread_t thread;
    own_priority = priority;
    look = (struct timespec){.tv_sec = (time_t)(look_ns / 1000000000), .tv_nsec = (long)(look_ns % 1000000000)};
    if (pthread_create(&thread, NULL, watch, NULL) != 0 || pthread_detach(thread) != 0) {
        hal_panic("watchdog: cannot create its thread");
    }
}

void watchdog_feed(void) {
    if (atomic_fetch_add(&feeds, 1) == UINT32_MAX) {
        (void)atomic_fetch_add(&feeds, 1); /* skips 0, which means that the watchdog has not been fed yet */
    }
}
