/* UART of the Cortex-M System Design Kit (ARM DDI 0479, chapter 4.3), which buffers one byte in each direction. */
#include <board.h> /* from the image's -I folder */

#include "../cortex_m/drivers.h"
#include "../hal.h"
#include "../slcan/slcan_hal.h"

#define UART_DATA REGISTER(BOARD_UART_BASE + 0x00u)
#define UART_STATE REGISTER(BOARD_UART_BASE + 0x04u)
#define UART_STATE_TX_FULL (1u << 0)
#define UART_STATE_RX_FULL (1u << 1)
#define UART_STATE_RX_OVERRUN (1u << 3) /* cleared by writing 1 */
#define UART_CONTROL REGISTER(BOARD_UART_BASE + 0x08u)
#define UART_CONTROL_TX_ENABLE (1u << 0)
#define UART_CONTROL_RX_ENABLE (1u << 1)
#define UART_CONTROL_TX_INTERRUPT (1u << 2)
#define UART_CONTROL_RX_INTERRUPT (1u << 3)
#define UART_INTERRUPT REGISTER(BOARD_UART_BASE + 0x0Cu) /* cleared by writing 1 */
#define UART_INTERRUPT_TX (1u << 0)
#define UART_INTERRUPT_RX (1u << 1)
#define UART_DIVIDER REGISTER(BOARD_UART_BASE + 0x10u)
#define UART_DIVIDER_MIN 16u /* 1.5625 Mbaud, this UART's maximum; for the required rate, see docs/porting.md */
#define UART_PART_NUMBER REGISTER(BOARD_UART_BASE + 0xFE0u)
#define UART_PART_NUMBER_CMSDK 0x21u

void uart_start(void) {
    if (UART_PART_NUMBER != UART_PART_NUMBER_CMSDK) {
        hal_panic("UART 0 does not answer with the CMSDK part number");
    }
    UART_DIVIDER = UART_DIVIDER_MIN;
    UART_CONTROL =
        UART_CONTROL_TX_ENABLE | UART_CONTROL_RX_ENABLE | UART_CONTROL_TX_INTERRUPT | UART_CONTROL_RX_INTERRUPT;
    NVIC_SET_ENABLE(BOARD_UART_RX_INTERRUPT) = NVIC_BIT(BOARD_UART_RX_INTERRUPT);
    NVIC_SET_ENABLE(BOARD_UART_TX_INTERRUPT) = NVIC_BIT(BOARD_UART_TX_INTERRUPT);
}

void uart_rx_handler(void) {
    UART_INTERRUPT = UART_INTERRUPT_RX;
    uint32_t state = UART_STATE;
    while ((state & UART_STATE_RX_FULL) != 0) {
        if ((state & UART_STATE_RX_OVERRUN) != 0) {
            UART_STATE = UART_STATE_RX_OVERRUN;
            slcan_link_overrun(&slcan_hal_link);
        }
        slcan_link_put_byte(&slcan_hal_link, (uint8_t)UART_DATA, clock_us());
        state = UART_STATE;
    }
}

void uart_tx_handler(void) {
    UART_INTERRUPT = UART_INTERRUPT_TX;
    uint8_t byte;
    while ((UART_STATE & UART_STATE_TX_FULL) == 0 && slcan_link_take_byte(&slcan_hal_link, &byte)) {
        UART_DATA = byte;
    }
}

void serial_start_transmission(void) {
    /* The UART interrupts when a byte has been sent. Since no byte precedes the first one, software triggers that
     * interrupt. The interrupt handler is thus the only consumer of the link's bytes. */
    NVIC_SET_PENDING(BOARD_UART_TX_INTERRUPT) = NVIC_BIT(BOARD_UART_TX_INTERRUPT);
}

void serial_wait(void) {
    wait_for_interrupt();
}

void serial_write_polled(uint8_t byte) {
    while ((UART_STATE & UART_STATE_TX_FULL) != 0) {
    }
    UART_DATA = byte;
}
