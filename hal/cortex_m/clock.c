/* SysTick as the 1 kHz tick and, between ticks, as the microsecond clock. */
#include <board.h> /* from the image's -I folder */
#include <stdbool.h>

#include "drivers.h"

#define CYCLES_PER_US (BOARD_CLOCK_HZ / 1000000u)
#define CYCLES_PER_TICK (CLOCK_TICK_US * CYCLES_PER_US)

static volatile uint32_t tick_us; /* time of the last tick */

void clock_start(void) {
    SYSTICK_RELOAD = CYCLES_PER_TICK - 1u;
    SYSTICK_VALUE = 0;
    SYSTICK_CONTROL = SYSTICK_CONTROL_ENABLE | SYSTICK_CONTROL_INTERRUPT | SYSTICK_CONTROL_CORE_CLOCK;
}

void systick_handler(void) {
    tick_us += CLOCK_TICK_US;
}

uint32_t clock_us(void) {
    uint32_t tick;
    uint32_t value;
    bool pending;
    do { /* read again if a tick occurred meanwhile */
        tick = tick_us;
        pending = (SCB_INTERRUPT_STATE & SCB_INTERRUPT_STATE_SYSTICK_PENDING) != 0;
        value = SYSTICK_VALUE;
    } while (tick != tick_us || pending != ((SCB_INTERRUPT_STATE & SCB_INTERRUPT_STATE_SYSTICK_PENDING) != 0));
    /* SysTick requests its interrupt when it reaches 0, and reloads one cycle later. */
    uint32_t cycles = value == 0 ? 0 : CYCLES_PER_TICK - value;
    /* Interrupts do not preempt each other, so the caller may be an interrupt handler that runs before that of the
     * pending tick. */
    return tick + (pending ? CLOCK_TICK_US : 0u) + cycles / CYCLES_PER_US;
}

uint32_t clock_tick_us(void) {
    return tick_us;
}
