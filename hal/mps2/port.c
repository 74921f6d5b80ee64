/* The HAL on an MPS2 board. UART 0 carries CAN (hal/slcan). */
#include <board.h> /* from the image's -I folder */

#include "../cortex_m/drivers.h"
#include "../hal.h"
#include "../slcan/slcan_hal.h"

#define WATCHDOG_TIMEOUT_US 10000u

void hal_init(void) {
    uart_start(); /* first, since a panic is reported through it */
    watchdog_start(WATCHDOG_TIMEOUT_US);
    clock_start();
    hal_enable_drives(false);
}

can_profile_t hal_can_profile(void) {
    return (BOARD_BUTTONS & BOARD_BUTTON_CLASSIC_CAN) != 0 ? CAN_PROFILE_CLASSIC : CAN_PROFILE_FD;
}

void hal_watchdog_feed(void) {
    watchdog_feed();
}

void hal_enable_drives(bool enable) {
    if (enable) {
        BOARD_LEDS |= BOARD_LED_DRIVE_ENABLE;
    } else {
        BOARD_LEDS &= ~BOARD_LED_DRIVE_ENABLE;
    }
}

bool drives_enabled(void) {
    return (BOARD_LEDS & BOARD_LED_DRIVE_ENABLE) != 0;
}

_Noreturn void hal_panic(const char *cause) {
    static volatile bool panicking;
    hal_enable_drives(false);
    interrupts_off();
    if (!panicking) { /* if already panicking, the report itself faulted: do not try again */
        panicking = true;
        watchdog_stop(); /* prevents a reset, which would lose the cause; the drives are already disabled */
        slcan_hal_report_panic(cause);
    }
    for (;;) {
        wait_for_interrupt();
    }
}
