/* Functions shared by the port's files, in addition to drivers.h. */
#ifndef COMANIP_NRF51_WATCHDOG_H
#define COMANIP_NRF51_WATCHDOG_H

#include <stdint.h>

/* Panics if the watchdog was not fed in time. Called by the tick's interrupt. tick_us: the tick's time. */
void watchdog_check(uint32_t tick_us);

#endif
