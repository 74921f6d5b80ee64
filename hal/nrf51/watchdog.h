/* Within the port, beside drivers.h. */
#ifndef COMANIP_NRF51_WATCHDOG_H
#define COMANIP_NRF51_WATCHDOG_H

#include <stdint.h>

/* By the tick's interrupt. tick_us: its time. Panics if nobody has fed the watchdog for its time. */
void watchdog_check(uint32_t tick_us);

#endif
