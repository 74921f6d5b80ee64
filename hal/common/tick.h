/* Implements hal_wait_tick() for ports whose timer interrupts at each tick (clock.h). */
#ifndef COMANIP_HAL_TICK_H
#define COMANIP_HAL_TICK_H

#include "../../firmware/protocol/port_status.h"

/* Fills in the missed ticks and the longest tick. A port calls it in its hal_port_status(). */
void tick_status(port_status_t *status);

#endif
