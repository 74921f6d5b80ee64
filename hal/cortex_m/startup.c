/* Reset: vector table, FPU, memory, then the firmware. Every fault ends in hal_panic(). */
#include "../../firmware/main.h"
#include "../hal.h"
#include "board.h"
#include "drivers.h"

#define INTERRUPT_COUNT 32

/* From the linker script. */
extern uint32_t link_stack_top[];
extern const uint32_t link_data_image[];
extern uint32_t link_data_start[];
extern uint32_t link_data_end[];
extern uint32_t link_bss_start[];
extern uint32_t link_bss_end[];

typedef void handler_t(void);

typedef struct {
    uint32_t *stack_top;
    handler_t *exception[15];
    handler_t *interrupt[INTERRUPT_COUNT];
} vector_table_t;

_Noreturn void reset_handler(void);

_Noreturn void reset_handler(void) {
    const uint32_t *image = link_data_image;
    for (uint32_t *word = link_data_start; word < link_data_end; word++) {
        *word = *image++;
    }
    for (uint32_t *word = link_bss_start; word < link_bss_end; word++) {
        *word = 0;
    }
    SCB_HANDLER_CONTROL |= SCB_HANDLER_CONTROL_FAULTS;
#ifdef __ARM_FP
    SCB_COPROCESSOR_ACCESS |= SCB_COPROCESSOR_ACCESS_FPU;
#endif
    __asm__ volatile("dsb\n\tisb" ::: "memory");
    firmware_main();
    hal_panic("the firmware's loop ended");
}

static void nmi_handler(void) {
    hal_panic("watchdog: not fed in time");
}

static void hard_fault_handler(void) {
    hal_panic("hard fault");
}

static void memory_fault_handler(void) {
    hal_panic("memory management fault");
}

static void bus_fault_handler(void) {
    hal_panic("bus fault");
}

static void usage_fault_handler(void) {
    hal_panic("usage fault");
}

static void unexpected_handler(void) {
    hal_panic("unexpected interrupt");
}

__attribute__((section(".vectors"), used)) static const vector_table_t vector_table = {
    .stack_top = link_stack_top,
    .exception =
        {
            reset_handler,
            nmi_handler,
            hard_fault_handler,
            memory_fault_handler,
            bus_fault_handler,
            usage_fault_handler,
            [10] = unexpected_handler, /* SVCall; those left out are reserved */
            [11] = unexpected_handler, /* debug monitor */
            [13] = unexpected_handler, /* PendSV */
            [14] = systick_handler,
        },
    /* Only these two are enabled. */
    .interrupt =
        {
            [BOARD_UART_RX_INTERRUPT] = uart_rx_handler,
            [BOARD_UART_TX_INTERRUPT] = uart_tx_handler,
        },
};
