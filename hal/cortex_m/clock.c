/* SysTick: the 1 kHz tick, and between ticks the microseconds. */
#include <board.h> /* the image's, by its -I */
#include <stdbool.h>

#include "../slcan/slcan_hal.h"
#include "drivers.h"

#define TICK_US 1000u
#define CYCLES_PER_US (BOARD_CLOCK_HZ / 1000000u)
#define CYCLES_PER_TICK (TICK_US * CYCLES_PER_US)

static volatile uint32_t tick_us; /* time of the last tick */
static uint32_t given_tick_us;    /* the one that clock_wait_tick() gave last */

void clock_start(void) {
    SYSTICK_RELOAD = CYCLES_PER_TICK - 1u;
    SYSTICK_VALUE = 0;
    SYSTICK_CONTROL = SYSTICK_CONTROL_ENABLE | SYSTICK_CONTROL_INTERRUPT | SYSTICK_CONTROL_CORE_CLOCK;
}

void systick_handler(void) {
    tick_us += TICK_US;
}

uint32_t clock_us(void) {
    uint32_t tick;
    uint32_t value;
    bool pending;
    do { /* again if a tick passed meanwhile */
        tick = tick_us;
        pending = (SCB_INTERRUPT_STATE & SCB_INTERRUPT_STATE_SYSTICK_PENDING) != 0;
        value = SYSTICK_VALUE;
    } while (tick != tick_us || pending != ((SCB_INTERRUPT_STATE & SCB_INTERRUPT_STATE_SYSTICK_PENDING) != 0));
    /* SysTick asks for its interrupt when it reaches 0, and only then counts down again from the reload value. */
    uint32_t cycles = value == 0 ? 0 : CYCLES_PER_TICK - value;
    /* Interrupts do not interrupt each other: the one that calls this may be ahead of the tick's own. */
    return tick + (pending ? TICK_US : 0u) + cycles / CYCLES_PER_US;
}

uint32_t clock_wait_tick(void) {
    /* With interrupts off a tick cannot slip in between the question and the sleep; it still ends the sleep. */
    interrupts_off();
    while (tick_us == given_tick_us) {
        wait_for_interrupt();
        interrupts_on();
        interrupts_off();
    }
    given_tick_us = tick_us;
    interrupts_on();
    return given_tick_us;
}
