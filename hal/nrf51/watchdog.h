/* Functions that the port's files share, in addition to drivers.h. */
#ifndef COMANIP_NRF51_WATCHDOG_H
#define COMANIP_NRF51_WATCHDOG_H

#include <stdint.h>

/* Called by the tick's interrupt. tick_us: its time. Panics if the watchdog was not fed in time. */
void watchdog_check(uint32_t tick_us);

#endif
