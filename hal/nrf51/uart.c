/* The nRF51's UART (manual, chapter 29), 1 Mbaud. It buffers one byte to send and six received bytes. */
#include "../cortex_m/drivers.h"
#include "../slcan/slcan_hal.h"
#include "board.h"

#define UART(offset) REGISTER(0x40002000u + (offset))
#define UART_START_RX UART(0x000u)
#define UART_START_TX UART(0x008u)
#define UART_RX_READY UART(0x108u)
#define UART_TX_READY UART(0x11Cu)
#define UART_INTERRUPT_ENABLE UART(0x304u)
#define UART_INTERRUPT_RX_READY (1u << 2)
#define UART_INTERRUPT_TX_READY (1u << 7)
#define UART_ERROR UART(0x480u) /* cleared by writing 1 */
#define UART_ERROR_OVERRUN (1u << 0)
#define UART_ENABLE UART(0x500u)
#define UART_ENABLE_ON 4u
#define UART_PIN_TX UART(0x50Cu)
#define UART_PIN_RX UART(0x514u)
#define UART_RX_DATA UART(0x518u)
#define UART_TX_DATA UART(0x51Cu)
#define UART_BAUD_RATE UART(0x524u)
#define UART_BAUD_RATE_1M 0x10000000u /* the UART's maximum; docs/porting.md states the required rate */

/* True while a byte is being sent. The UART itself does not show whether it can accept a byte; it only signals that a
 * byte has been sent. */
static volatile bool sending;

void uart_start(void) {
    BOARD_GPIO_OUT_SET = 1u << BOARD_PIN_UART_TX;
    BOARD_GPIO_OUTPUT = 1u << BOARD_PIN_UART_TX;
    BOARD_GPIO_CONFIG(BOARD_PIN_UART_RX) = BOARD_GPIO_CONFIG_INPUT;
    UART_PIN_TX = BOARD_PIN_UART_TX;
    UART_PIN_RX = BOARD_PIN_UART_RX;
    UART_BAUD_RATE = UART_BAUD_RATE_1M;
    UART_ENABLE = UART_ENABLE_ON;
    UART_START_RX = 1;
    UART_START_TX = 1;
    UART_INTERRUPT_ENABLE = UART_INTERRUPT_RX_READY | UART_INTERRUPT_TX_READY;
    NVIC_SET_ENABLE(BOARD_UART_INTERRUPT) = NVIC_BIT(BOARD_UART_INTERRUPT);
}

static void receive(void) {
    while (UART_RX_READY != 0) {
        UART_RX_READY = 0; /* cleared before the byte is read, because reading lets the next byte set it again */
        if ((UART_ERROR & UART_ERROR_OVERRUN) != 0) {
            UART_ERROR = UART_ERROR_OVERRUN;
            slcan_link_overrun(&slcan_hal_link);
        }
        slcan_link_put_byte(&slcan_hal_link, (uint8_t)UART_RX_DATA, clock_us());
    }
}

static void transmit(void) {
    if (UART_TX_READY != 0) {
        UART_TX_READY = 0;
        sending = false;
    }
    uint8_t byte;
    if (!sending && slcan_link_take_byte(&slcan_hal_link, &byte)) {
        sending = true;
        UART_TX_DATA = byte;
    }
}

void uart_handler(void) {
    receive();
    transmit();
}

void serial_start_transmission(void) {
    /* Makes the interrupt handler run, which is the only consumer of the link's bytes. */
    NVIC_SET_PENDING(BOARD_UART_INTERRUPT) = NVIC_BIT(BOARD_UART_INTERRUPT);
}

void serial_wait(void) {
    wait_for_interrupt();
    /* Restarts the transmission: if the reader of QEMU's serial line delays a byte, QEMU does not raise the interrupt
     * that should follow this byte. */
    serial_start_transmission();
}

void serial_write_polled(uint8_t byte) {
    while (sending && UART_TX_READY == 0) {
    }
    UART_TX_READY = 0;
    sending = true;
    UART_TX_DATA = byte;
}
