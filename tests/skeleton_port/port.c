/* A minimal port. It has no watchdog and no enable line, so the functions for them do nothing. */
#include "../cortex_m/drivers.h"
#include "../hal.h"
#include "can.h"
#include "semihosting.h"

void hal_init(void) {
    can_start();
    clock_start();
}

can_profile_t hal_can_profile(void) {
    return CAN_PROFILE_FD;
}

void hal_watchdog_feed(void) {
}

void hal_enable_drives(bool enable) {
    (void)enable;
}

_Noreturn void hal_panic(const char *cause) {
    (void)cause;
    for (;;) {
        semihosting_exit(false);
    }
}
