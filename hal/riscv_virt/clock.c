/* The machine timer (CLINT) as the 1 kHz tick and, between ticks, as the microsecond clock. */
#include "board.h"
#include "drivers.h"

#define TIMER_COMPARE_LOW REGISTER(BOARD_CLINT_BASE + 0x4000u)
#define TIMER_COMPARE_HIGH REGISTER(BOARD_CLINT_BASE + 0x4004u)
#define TIMER_LOW REGISTER(BOARD_CLINT_BASE + 0xBFF8u)
#define TIMER_HIGH REGISTER(BOARD_CLINT_BASE + 0xBFFCu)

#define COUNTS_PER_US (BOARD_TIMER_HZ / 1000000u)
#define COUNTS_PER_TICK (CLOCK_TICK_US * COUNTS_PER_US)

static volatile uint32_t tick_us;  /* time of the last tick */
static uint64_t next_tick;         /* time of the next tick, in counts of the timer */
static volatile uint32_t tick_low; /* low half of the timer's count at the last tick */

static uint64_t timer_now(void) {
    uint32_t high;
    uint32_t low;
    do {
        high = TIMER_HIGH;
        low = TIMER_LOW;
    } while (high != TIMER_HIGH);
    return (uint64_t)high << 32 | low;
}

static void set_compare(uint64_t count) {
    TIMER_COMPARE_HIGH = UINT32_MAX; /* prevents an early interrupt while only one half has been written */
    TIMER_COMPARE_LOW = (uint32_t)count;
    TIMER_COMPARE_HIGH = (uint32_t)(count >> 32);
}

void clock_start(void) {
    uint64_t now = timer_now();
    tick_low = (uint32_t)now;
    next_tick = now + COUNTS_PER_TICK;
    set_compare(next_tick);
    interrupts_enable(MIE_TIMER);
}

void clock_handler(void) {
    uint64_t now = timer_now();
    while (next_tick <= now) { /* more than once if interrupts were off for a whole tick */
        tick_us += CLOCK_TICK_US;
        tick_low = (uint32_t)next_tick;
        next_tick += COUNTS_PER_TICK;
    }
    set_compare(next_tick);
    watchdog_check();
}

uint32_t clock_tick_us(void) {
    return tick_us;
}

uint32_t clock_us(void) {
    uint32_t tick;
    uint32_t count;
    do { /* read again if a tick occurred meanwhile */
        tick = tick_us;
        count = TIMER_LOW - tick_low;
    } while (tick != tick_us);
    return tick + count / COUNTS_PER_US;
}
