/* Watchdog of the Cortex-M System Design Kit (ARM DDI 0479, chapter 4.5). The first time it expires, it triggers the
 * NMI; the second time, a reset. */
#include <board.h> /* from the image's -I folder */

#include "../cortex_m/drivers.h"
#include "../hal.h"

#define WATCHDOG_LOAD REGISTER(BOARD_WATCHDOG_BASE + 0x000u)
#define WATCHDOG_CONTROL REGISTER(BOARD_WATCHDOG_BASE + 0x008u)
#define WATCHDOG_CONTROL_INTERRUPT (1u << 0)
#define WATCHDOG_CONTROL_RESET (1u << 1)
#define WATCHDOG_CLEAR REGISTER(BOARD_WATCHDOG_BASE + 0x00Cu)
#define WATCHDOG_LOCK REGISTER(BOARD_WATCHDOG_BASE + 0xC00u)
#define WATCHDOG_LOCK_KEY 0x1ACCE551u
#define WATCHDOG_PART_NUMBER REGISTER(BOARD_WATCHDOG_BASE + 0xFE0u)
#define WATCHDOG_PART_NUMBER_CMSDK 0x24u

/* The watchdog is unlocked only during this write, so that a stray write cannot stop it. */
static void write_unlocked(volatile uint32_t *target, uint32_t value) {
    WATCHDOG_LOCK = WATCHDOG_LOCK_KEY;
    *target = value;
    WATCHDOG_LOCK = 0;
}

void watchdog_start(uint32_t timeout_us) {
    if (WATCHDOG_PART_NUMBER != WATCHDOG_PART_NUMBER_CMSDK) {
        hal_panic("the watchdog does not answer with the CMSDK part number");
    }
    write_unlocked(&WATCHDOG_LOAD, timeout_us * (BOARD_CLOCK_HZ / 1000000u));
    write_unlocked(&WATCHDOG_CONTROL, WATCHDOG_CONTROL_INTERRUPT | WATCHDOG_CONTROL_RESET);
}

void watchdog_feed(void) {
    write_unlocked(&WATCHDOG_CLEAR, 1u);
}

void watchdog_stop(void) {
    write_unlocked(&WATCHDOG_CONTROL, 0);
}
