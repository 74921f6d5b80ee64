/* The definitions that hal/cortex_m needs, for a board with a CAN controller. */
#ifndef COMANIP_BOARD_H
#define COMANIP_BOARD_H

#include "../cortex_m/cortex_m.h"

#define BOARD_CLOCK_HZ 25000000u

#define BOARD_CAN_INTERRUPT 0u
#define BOARD_INTERRUPT_COUNT 32

void systick_handler(void);
void can_handler(void);

#define BOARD_SYSTICK_HANDLER systick_handler
#define BOARD_INTERRUPT_HANDLERS [BOARD_CAN_INTERRUPT] = can_handler

#endif
