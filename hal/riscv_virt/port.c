/* The HAL on QEMU's virt machine. CAN goes over the UART (hal/slcan).
 *
 * The machine has no watchdog: the tick's interrupt checks that the firmware's loop runs. It detects a loop that hangs,
 * but, unlike a watchdog, not one that hangs with interrupts off. The machine has no output either that could take the
 * drives' power away: a panic stops the commands, and each drive brakes by its own timeout (3 ms). */
#include "../hal.h"
#include "../slcan/slcan_hal.h"
#include "board.h"
#include "drivers.h"

#define WATCHDOG_TIMEOUT_US 10000u

static volatile uint32_t fed_us;
static bool enabled; /* instead of a line */

void hal_init(void) {
    uart_start();
    plic_start();
    clock_start();
    interrupts_on();
}

can_profile_t hal_can_profile(void) {
    return CAN_PROFILE_FD; /* the machine has no input to select by */
}

void hal_watchdog_feed(void) {
    fed_us = clock_tick_us();
}

void hal_enable_drives(bool enable) {
    enabled = enable;
}

bool drives_enabled(void) {
    return enabled;
}

void watchdog_check(void) {
    if (clock_tick_us() - fed_us >= WATCHDOG_TIMEOUT_US) {
        hal_panic("watchdog: not fed in time");
    }
}

_Noreturn void hal_panic(const char *cause) {
    static bool panicking;
    hal_enable_drives(false);
    interrupts_off();
    if (!panicking) { /* else a fault during the report: nothing more can be reported */
        panicking = true;
        slcan_hal_report_panic(cause);
    }
    for (;;) {
        wait_for_interrupt();
    }
}
