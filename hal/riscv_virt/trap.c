/* Handles traps: the tick, the UART, and faults, which end in hal_panic(). */
#include "../hal.h"
#include "board.h"
#include "drivers.h"

/* Causes of traps, as given in mcause. */
#define CAUSE_FETCH_MISALIGNED 0u
#define CAUSE_FETCH_ACCESS 1u
#define CAUSE_ILLEGAL_INSTRUCTION 2u
#define CAUSE_LOAD_MISALIGNED 4u
#define CAUSE_LOAD_ACCESS 5u
#define CAUSE_STORE_MISALIGNED 6u
#define CAUSE_STORE_ACCESS 7u
#define CAUSE_TIMER (MCAUSE_INTERRUPT | 7u)
#define CAUSE_EXTERNAL (MCAUSE_INTERRUPT | 11u)

/* Defined by the linker script. */
extern uint32_t link_thread_stack_end[];

/* Panics. kind: the fault that the processor detected. If its cause is an overflow of the thread's stack, the panic
 * reports that instead. */
static _Noreturn void fault(const char *kind, uintptr_t thread_stack) {
    hal_panic(thread_stack < (uintptr_t)link_thread_stack_end ? "stack overflow" : kind);
}

void trap_handler(uint32_t cause, uintptr_t thread_stack) {
    switch (cause) {
    case CAUSE_TIMER: clock_handler(); break;
    case CAUSE_EXTERNAL: plic_handler(); break;
    case CAUSE_FETCH_ACCESS:
    case CAUSE_LOAD_ACCESS:
    case CAUSE_STORE_ACCESS: fault("access fault", thread_stack);
    case CAUSE_FETCH_MISALIGNED:
    case CAUSE_LOAD_MISALIGNED:
    case CAUSE_STORE_MISALIGNED: fault("misaligned access", thread_stack);
    case CAUSE_ILLEGAL_INSTRUCTION: fault("illegal instruction", thread_stack);
    default: hal_panic("unexpected trap");
    }
}
