/* BBC micro:bit, or another board with an nRF51822: constants for the drivers (Nordic, nRF51 Series Reference Manual
 * 3.0). */
#ifndef COMANIP_BOARD_H
#define COMANIP_BOARD_H

#include "../cortex_m/cortex_m.h"

/* Pins of port 0, as used on the micro:bit. */
#define BOARD_PIN_UART_TX 24u
#define BOARD_PIN_UART_RX 25u
#define BOARD_PIN_DRIVE_ENABLE                                                                                         \
    13u /* the row of the first LED represents the drives' enable line; a pull-down keeps it low at reset */
#define BOARD_PIN_CLASSIC_CAN 17u /* button A: classic CAN if pressed (low) at reset */

#define BOARD_GPIO_OUT REGISTER(0x50000504u)
#define BOARD_GPIO_OUT_SET REGISTER(0x50000508u)
#define BOARD_GPIO_OUT_CLEAR REGISTER(0x5000050Cu)
#define BOARD_GPIO_IN REGISTER(0x50000510u)
#define BOARD_GPIO_OUTPUT REGISTER(0x50000518u) /* writing 1 to a bit makes the pin an output */
#define BOARD_GPIO_CONFIG(pin) REGISTER(0x50000700u + 4u * (pin))
#define BOARD_GPIO_CONFIG_INPUT 0u
#define BOARD_GPIO_CONFIG_INPUT_PULL_UP (3u << 2)

#define BOARD_UART_INTERRUPT 2u
#define BOARD_TIMER_INTERRUPT 8u
#define BOARD_INTERRUPT_COUNT 32

void uart_handler(void);
void timer_handler(void);

#define BOARD_SYSTICK_HANDLER unexpected_handler /* the nRF51 has no SysTick */
#define BOARD_INTERRUPT_HANDLERS [BOARD_UART_INTERRUPT] = uart_handler, [BOARD_TIMER_INTERRUPT] = timer_handler

#endif
