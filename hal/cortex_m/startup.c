/* The vector table, and the handlers of reset and faults. The reset handler sets up stacks, memory and FPU, and then
 * runs the firmware. Every fault ends in hal_panic(). */
#include <board.h> /* from the image's -I folder */

#include "../../firmware/main.h"
#include "../hal.h"
#include "drivers.h"

/* Defined by the linker script. */
extern uint32_t link_exception_stack_top[];
extern const uint32_t link_data_image[];
extern uint32_t link_data_start[];
extern uint32_t link_data_end[];
extern uint32_t link_bss_start[];
extern uint32_t link_bss_end[];

typedef void handler_t(void);

typedef struct {
    uint32_t *stack_top;
    handler_t *exception[15];
    handler_t *interrupt[BOARD_INTERRUPT_COUNT];
} vector_table_t;

void reset_handler(void);
_Noreturn void thread(void);

/* Switches to the thread's stack, since the main stack is for exceptions. The function is naked, because it must not
 * use the main stack itself. */
__attribute__((naked)) void reset_handler(void) {
    __asm__ volatile("ldr r0, =link_thread_stack_top\n\t"
                     "msr psp, r0\n\t"
                     "movs r0, #2\n\t"
                     "msr control, r0\n\t"
                     "isb\n\t"
                     "bl thread\n\t"
                     ".ltorg");
}

_Noreturn void thread(void) {
    const uint32_t *image = link_data_image;
    for (uint32_t *word = link_data_start; word < link_data_end; word++) {
        *word = *image++;
    }
    for (uint32_t *word = link_bss_start; word < link_bss_end; word++) {
        *word = 0;
    }
#if __ARM_ARCH > 6
    SCB_HANDLER_CONTROL |= SCB_HANDLER_CONTROL_FAULTS;
#endif
#ifdef __ARM_FP
    SCB_COPROCESSOR_ACCESS |= SCB_COPROCESSOR_ACCESS_FPU;
#endif
    __asm__ volatile("dsb\n\tisb" ::: "memory");
    stack_guard_start();
    firmware_main();
    hal_panic("the firmware's loop ended");
}

/* Panics. Reports a stack overflow, if there was one, or else `kind`, the kind of fault that the processor detected. */
static _Noreturn void fault(const char *kind) {
    hal_panic(stack_overflowed() ? "stack overflow" : kind);
}

static void nmi_handler(void) {
    hal_panic("watchdog: not fed in time");
}

static void hard_fault_handler(void) {
    fault("hard fault");
}

#if __ARM_ARCH > 6
static void memory_fault_handler(void) {
    fault("memory management fault");
}

static void bus_fault_handler(void) {
    fault("bus fault");
}

static void usage_fault_handler(void) {
    fault("usage fault");
}
#endif

void unexpected_handler(void) {
    hal_panic("unexpected interrupt");
}

__attribute__((section(".vectors"), used)) static const vector_table_t vector_table = {
    .stack_top = link_exception_stack_top,
    .exception =
        {
            reset_handler,
            nmi_handler,
            hard_fault_handler,
#if __ARM_ARCH > 6
            memory_fault_handler,
            bus_fault_handler,
            usage_fault_handler,
            [11] = unexpected_handler, /* debug monitor */
#endif
            [10] = unexpected_handler, /* SVCall; the numbers left out are reserved */
            [13] = unexpected_handler, /* PendSV */
            [14] = BOARD_SYSTICK_HANDLER,
        },
    .interrupt = {BOARD_INTERRUPT_HANDLERS}, /* no other interrupts are enabled */
};
