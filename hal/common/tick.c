#include "tick.h"

#include <board.h> /* from the image's -I folder: the interrupt mask and wait_for_interrupt() */

#include "../hal.h"
#include "clock.h"

static struct {
    bool running;
    uint32_t given_us; /* time of the tick last returned by hal_wait_tick() */
    uint32_t missed, longest_us;
} ticks;

static void measure(uint32_t now_us) {
    const uint32_t spent_us = now_us - ticks.given_us;
    ticks.longest_us = spent_us > ticks.longest_us ? spent_us : ticks.longest_us;
    for (uint32_t after_us = ticks.given_us + CLOCK_TICK_US; after_us != clock_tick_us(); after_us += CLOCK_TICK_US) {
        ticks.missed++;
    }
}

bool hal_wait_tick(uint32_t *now_us) {
    /* With interrupts off, no tick can come between the check and the sleep. A pending interrupt still ends the
     * sleep. */
    interrupts_off();
    const uint32_t end_us = clock_us();
    while (clock_tick_us() == ticks.given_us) {
        wait_for_interrupt();
        interrupts_on();
        interrupts_off();
    }
    if (ticks.running) { /* before the first call, there is no tick to measure */
        measure(end_us);
    }
    ticks.running = true;
    ticks.given_us = clock_tick_us();
    interrupts_on();
    *now_us = ticks.given_us;
    return true;
}

void tick_status(port_status_t *status) {
    status->missed_ticks = port_count(ticks.missed);
    status->longest_tick_us = port_count(ticks.longest_us);
}
