/* What a port's timer provides to the tick loop (tick.c), which the ports share. A port with another
 * source of ticks uses neither. */
#ifndef COMANIP_HAL_CLOCK_H
#define COMANIP_HAL_CLOCK_H

#include <stdint.h>

#define CLOCK_TICK_US 1000u

/* Provided by the port: the time now, monotonic modulo 2^32. In interrupts, or with interrupts off. */
uint32_t clock_us(void);

/* Provided by the port: the time of the last tick, a multiple of CLOCK_TICK_US. The timer interrupts at each tick. */
uint32_t clock_tick_us(void);

#endif
