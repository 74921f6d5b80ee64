/* The interface between a port's timer and tick.c, the tick loop that several ports share. A port with a different
 * source of ticks uses neither file. */
#ifndef COMANIP_HAL_CLOCK_H
#define COMANIP_HAL_CLOCK_H

#include <stdint.h>

#define CLOCK_TICK_US 1000u

/* Provided by the port. Returns the current time, monotonic modulo 2^32. Called only in interrupts or with interrupts
 * off. */
uint32_t clock_us(void);

/* Provided by the port. Returns the time of the last tick, a multiple of CLOCK_TICK_US. The timer must interrupt at
 * each tick. */
uint32_t clock_tick_us(void);

#endif
