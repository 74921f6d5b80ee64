/* The HAL on a micro:bit. The UART carries CAN (hal/slcan). */
#include "../cortex_m/drivers.h"
#include "../hal.h"
#include "../slcan/slcan_hal.h"
#include "board.h"

#define WATCHDOG_TIMEOUT_US 10000u

void hal_init(void) {
    BOARD_GPIO_CONFIG(BOARD_PIN_CLASSIC_CAN) = BOARD_GPIO_CONFIG_INPUT_PULL_UP;
    uart_start(); /* first, because a panic is reported through the UART */
    watchdog_start(WATCHDOG_TIMEOUT_US);
    clock_start();
    hal_enable_drives(false);
    BOARD_GPIO_OUTPUT = 1u << BOARD_PIN_DRIVE_ENABLE;
}

can_profile_t hal_can_profile(void) {
    return (BOARD_GPIO_IN & 1u << BOARD_PIN_CLASSIC_CAN) == 0 ? CAN_PROFILE_CLASSIC : CAN_PROFILE_FD;
}

void hal_watchdog_feed(void) {
    watchdog_feed();
}

void hal_enable_drives(bool enable) {
    if (enable) {
        BOARD_GPIO_OUT_SET = 1u << BOARD_PIN_DRIVE_ENABLE;
    } else {
        BOARD_GPIO_OUT_CLEAR = 1u << BOARD_PIN_DRIVE_ENABLE;
    }
}

bool drives_enabled(void) {
    return (BOARD_GPIO_OUT & 1u << BOARD_PIN_DRIVE_ENABLE) != 0;
}

_Noreturn void hal_panic(const char *cause) {
    static volatile bool panicking;
    hal_enable_drives(false);
    interrupts_off();
    if (!panicking) { /* if already panicking, the report itself faulted: do not try again */
        panicking = true;
        slcan_hal_report_panic(cause);
    }
    for (;;) {
        watchdog_feed(); /* prevents a reset, because the arm is safe while the drives are disabled */
    }
}
