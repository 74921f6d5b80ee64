/* MPS2 board with AN505 (Cortex-M33): constants for the drivers (ARM DAI 0505). The image runs in secure
 * state. */
#ifndef COMANIP_BOARD_H
#define COMANIP_BOARD_H

#include "../cortex_m/cortex_m.h"

#define BOARD_CLOCK_HZ 20000000u /* clock of core, SysTick, UART and watchdog */

#define BOARD_UART_BASE 0x50200000u /* UART 0 */
#define BOARD_UART_RX_INTERRUPT 32u
#define BOARD_UART_TX_INTERRUPT 33u

#define BOARD_WATCHDOG_BASE 0x50081000u /* the secure watchdog, which triggers the NMI when it expires */

#define BOARD_IO_BASE 0x50302000u /* LEDs and buttons */

#define BOARD_INTERRUPT_COUNT 64

#include "../mps2/mps2.h"

#endif
