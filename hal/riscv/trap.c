/* Traps: the tick, the UART, and faults, which end in hal_panic(). */
#include "../hal.h"
#include "board.h"
#include "drivers.h"

/* Values of mcause. */
#define CAUSE_FETCH_MISALIGNED 0u
#define CAUSE_FETCH_ACCESS 1u
#define CAUSE_ILLEGAL_INSTRUCTION 2u
#define CAUSE_LOAD_MISALIGNED 4u
#define CAUSE_LOAD_ACCESS 5u
#define CAUSE_STORE_MISALIGNED 6u
#define CAUSE_STORE_ACCESS 7u
#define CAUSE_TIMER (MCAUSE_INTERRUPT | 7u)
#define CAUSE_EXTERNAL (MCAUSE_INTERRUPT | 11u)

/* Aligned: the low bits of mtvec are its mode. */
__attribute__((interrupt("machine"), aligned(4))) void trap_handler(void) {
    switch (trap_cause()) {
    case CAUSE_TIMER:
        clock_handler();
        break;
    case CAUSE_EXTERNAL:
        plic_handler();
        break;
    case CAUSE_FETCH_ACCESS:
    case CAUSE_LOAD_ACCESS:
    case CAUSE_STORE_ACCESS:
        hal_panic("access fault");
    case CAUSE_FETCH_MISALIGNED:
    case CAUSE_LOAD_MISALIGNED:
    case CAUSE_STORE_MISALIGNED:
        hal_panic("misaligned access");
    case CAUSE_ILLEGAL_INSTRUCTION:
        hal_panic("illegal instruction");
    default:
        hal_panic("unexpected trap");
    }
}
