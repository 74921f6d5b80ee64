/* The nRF51's watchdog (manual, chapter 24) can only reset the chip, and cannot be stopped. The tick's interrupt
 * therefore checks whether the firmware feeds the watchdog, and panics after the timeout if it does not. Only if the
 * interrupts hang as well does the watchdog reset the chip, after twice the timeout. */
#include "watchdog.h"

#include "../cortex_m/drivers.h"
#include "../hal.h"
#include "board.h"

#define WATCHDOG(offset) REGISTER(0x40010000u + (offset))
#define WATCHDOG_START WATCHDOG(0x000u)
#define WATCHDOG_RELOAD_VALUE WATCHDOG(0x504u) /* periods of 32,768 Hz */
#define WATCHDOG_RELOAD_REQUEST WATCHDOG(0x600u)
#define WATCHDOG_RELOAD_REQUEST_KEY 0x6E524635u

static struct {
    uint32_t timeout_us;
    volatile bool fed;
    uint32_t fed_us; /* time of the tick at which the last feed was seen */
} watchdog;

void watchdog_start(uint32_t timeout_us) {
    watchdog.timeout_us = timeout_us;
    WATCHDOG_RELOAD_VALUE = 2u * timeout_us * 32u / 1000u;
    WATCHDOG_START = 1;
}

void watchdog_feed(void) {
    watchdog.fed = true;
    WATCHDOG_RELOAD_REQUEST = WATCHDOG_RELOAD_REQUEST_KEY;
}

void watchdog_check(uint32_t tick_us) {
    if (watchdog.fed) {
        watchdog.fed = false;
        watchdog.fed_us = tick_us;
    } else if (tick_us - watchdog.fed_us >= watchdog.timeout_us) {
        hal_panic("watchdog: not fed in time");
    }
}
