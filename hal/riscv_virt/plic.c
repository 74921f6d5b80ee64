/* Platform-level interrupt controller (RISC-V PLIC specification 1.0): routes the UART to hart 0 in machine mode. */
#include "../hal.h"
#include "board.h"
#include "drivers.h"

#define PLIC_PRIORITY(source) REGISTER(BOARD_PLIC_BASE + 4u * (source))
#define PLIC_ENABLE REGISTER(BOARD_PLIC_BASE + 0x2000u) /* sources 0..31, context 0 */
#define PLIC_THRESHOLD REGISTER(BOARD_PLIC_BASE + 0x200000u)
#define PLIC_CLAIM REGISTER(BOARD_PLIC_BASE + 0x200004u)

void plic_start(void) {
    PLIC_PRIORITY(BOARD_UART_INTERRUPT) = 1;
    PLIC_ENABLE = 1u << BOARD_UART_INTERRUPT;
    PLIC_THRESHOLD = 0;
    interrupts_enable(MIE_EXTERNAL);
}

void plic_handler(void) {
    uint32_t source = PLIC_CLAIM;
    if (source == 0) { /* the interrupt is no longer pending */
        return;
    }
    if (source != BOARD_UART_INTERRUPT) {
        hal_panic("unexpected interrupt");
    }
    uart_handler();
    PLIC_CLAIM = source;
}
