/* MPS2 board with AN385 (Cortex-M3), AN386 (Cortex-M4F) or AN500 (Cortex-M7): constants for the drivers, which are the
 * same for all three (ARM DAI 0385, 0386, 0500). */
#ifndef COMANIP_BOARD_H
#define COMANIP_BOARD_H

#include "../cortex_m/cortex_m.h"

#define BOARD_CLOCK_HZ 25000000u /* clock of core, SysTick, UART and watchdog */

#define BOARD_UART_BASE 0x40004000u /* UART 0 */
#define BOARD_UART_RX_INTERRUPT 0u
#define BOARD_UART_TX_INTERRUPT 1u

#define BOARD_WATCHDOG_BASE 0x40008000u /* triggers the NMI when it expires */

#define BOARD_IO_BASE 0x40028000u /* LEDs and buttons */

#define BOARD_INTERRUPT_COUNT 32

#include "mps2.h"

#endif
