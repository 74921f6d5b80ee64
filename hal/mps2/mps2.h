/* Definitions shared by the MPS2 boards: user LED 0, user button 0, and the interrupt handlers. */
#ifndef COMANIP_MPS2_H
#define COMANIP_MPS2_H

/* LED 0 represents the drives' enable line, because the board has no power stage. */
#define BOARD_LEDS REGISTER(BOARD_IO_BASE + 0x0u)
#define BOARD_LED_DRIVE_ENABLE (1u << 0)

/* Button 0, if held at reset, selects classic CAN. */
#define BOARD_BUTTONS REGISTER(BOARD_IO_BASE + 0x8u)
#define BOARD_BUTTON_CLASSIC_CAN (1u << 0)

void systick_handler(void);
void uart_rx_handler(void);
void uart_tx_handler(void);

void watchdog_stop(void);

#define BOARD_SYSTICK_HANDLER systick_handler
#define BOARD_INTERRUPT_HANDLERS                                                                                       \
    [BOARD_UART_RX_INTERRUPT] = uart_rx_handler, [BOARD_UART_TX_INTERRUPT] = uart_tx_handler

#endif
