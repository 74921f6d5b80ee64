/* MPS2 board with AN385 (Cortex-M3), AN386 (Cortex-M4F) or AN500 (Cortex-M7): what the drivers must know of it, which is the
 * same in these three (ARM DAI 0385, 0386, 0500). */
#ifndef COMANIP_BOARD_H
#define COMANIP_BOARD_H

#include "cortex_m.h"

#define BOARD_CLOCK_HZ 25000000u /* core, SysTick, UART and watchdog alike */

#define BOARD_UART_BASE 0x40004000u /* UART 0 */
#define BOARD_UART_RX_INTERRUPT 0
#define BOARD_UART_TX_INTERRUPT 1

#define BOARD_WATCHDOG_BASE 0x40008000u /* expires into the NMI */

/* User LED 0 stands for the drives' enable line: the board has no power stage of its own. */
#define BOARD_LEDS REGISTER(0x40028000u)
#define BOARD_LED_DRIVE_ENABLE (1u << 0)

/* User button 0, held at reset, chooses classic CAN. */
#define BOARD_BUTTONS REGISTER(0x40028008u)
#define BOARD_BUTTON_CLASSIC_CAN (1u << 0)

#endif
