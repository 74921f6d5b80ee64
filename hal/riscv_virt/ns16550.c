/* The 16550 UART, which buffers 16 bytes in each direction. */
#include "../hal.h"
#include "../slcan/slcan_hal.h"
#include "board.h"
#include "drivers.h"

#define UART_DATA BYTE_REGISTER(BOARD_UART_BASE + 0u)
#define UART_DIVISOR_LOW BYTE_REGISTER(BOARD_UART_BASE + 0u)
#define UART_INTERRUPT BYTE_REGISTER(BOARD_UART_BASE + 1u)
#define UART_DIVISOR_HIGH BYTE_REGISTER(BOARD_UART_BASE + 1u)
#define UART_INTERRUPT_RX 0x01u
#define UART_INTERRUPT_TX_EMPTY 0x02u
#define UART_FIFO BYTE_REGISTER(BOARD_UART_BASE + 2u)
#define UART_FIFO_ENABLE_AND_CLEAR 0x07u
#define UART_INTERRUPT_CAUSE BYTE_REGISTER(BOARD_UART_BASE + 2u) /* read-only; writes go to UART_FIFO */
#define UART_LINE BYTE_REGISTER(BOARD_UART_BASE + 3u)
#define UART_LINE_8N1 0x03u
#define UART_LINE_DIVISOR_ACCESS 0x80u
#define UART_STATE BYTE_REGISTER(BOARD_UART_BASE + 5u)
#define UART_STATE_RX_READY 0x01u
#define UART_STATE_RX_OVERRUN 0x02u /* cleared by reading */
#define UART_STATE_TX_EMPTY 0x20u
#define UART_SCRATCH BYTE_REGISTER(BOARD_UART_BASE + 7u)

#define UART_TX_FIFO_BYTES 16
#define UART_DIVISOR 1u /* the highest rate: 230,400 baud with this machine's 3.6864 MHz clock; QEMU ignores it */

void uart_start(void) {
    UART_SCRATCH = 0xA5u;
    if (UART_SCRATCH != 0xA5u) {
        hal_panic("the UART's scratch register does not hold what was written");
    }
    UART_LINE = UART_LINE_DIVISOR_ACCESS;
    UART_DIVISOR_LOW = UART_DIVISOR;
    UART_DIVISOR_HIGH = 0;
    UART_LINE = UART_LINE_8N1;
    UART_FIFO = UART_FIFO_ENABLE_AND_CLEAR;
    UART_INTERRUPT = UART_INTERRUPT_RX;
}

static void receive(void) {
    uint8_t state = UART_STATE;
    while ((state & UART_STATE_RX_READY) != 0) {
        if ((state & UART_STATE_RX_OVERRUN) != 0) {
            slcan_link_overrun(&slcan_hal_link);
        }
        slcan_link_put_byte(&slcan_hal_link, UART_DATA, clock_us());
        state = UART_STATE;
    }
}

static void transmit(void) {
    if ((UART_STATE & UART_STATE_TX_EMPTY) == 0) {
        return;
    }
    for (int i = 0; i < UART_TX_FIFO_BYTES; i++) {
        uint8_t byte;
        if (!slcan_link_take_byte(&slcan_hal_link, &byte)) {
            UART_INTERRUPT = UART_INTERRUPT_RX;
            return;
        }
        UART_DATA = byte;
    }
}

void uart_handler(void) {
    (void)UART_INTERRUPT_CAUSE; /* reading this register acknowledges the transmitter's interrupt */
    receive();
    transmit();
}

void serial_start_transmission(void) {
    UART_INTERRUPT = UART_INTERRUPT_RX | UART_INTERRUPT_TX_EMPTY; /* causes an interrupt at once if there is room */
}

void serial_wait(void) {
    wait_for_interrupt();
}

void serial_write_polled(uint8_t byte) {
    while ((UART_STATE & UART_STATE_TX_EMPTY) == 0) {
    }
    UART_DATA = byte;
}
