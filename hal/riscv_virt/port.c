/* The HAL on QEMU's virt machine. The UART carries CAN (hal/slcan).
 *
 * Since the machine has no watchdog, the tick's interrupt checks that the firmware's loop runs. Unlike a watchdog,
 * this check detects a hang only while interrupts are on. Nor does the machine have an output that could cut the
 * drives' power. After a panic, the firmware sends no more commands, and each drive brakes when its own timeout of
 * 3 ms expires. */
#include "../hal.h"
#include "../slcan/slcan_hal.h"
#include "board.h"
#include "drivers.h"

#define WATCHDOG_TIMEOUT_US 10000u

static volatile uint32_t fed_us;
static bool enabled; /* stands for the enable line of the drives, which the machine does not have */

void hal_init(void) {
    uart_start();
    plic_start();
    clock_start();
    interrupts_on();
}

can_profile_t hal_can_profile(void) {
    return CAN_PROFILE_FD; /* always, because the machine has no input that could select a profile */
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
    if (!panicking) { /* if already panicking, the report itself faulted: do not try again */
        panicking = true;
        slcan_hal_report_panic(cause);
    }
    for (;;) {
        wait_for_interrupt();
    }
}
