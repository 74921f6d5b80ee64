/* TIMER0 counts microseconds (nRF51 manual, chapter 18), because the nRF51 has no SysTick. */
#include "../cortex_m/drivers.h"
#include "board.h"
#include "watchdog.h"

#define CLOCK_START REGISTER(0x40000000u) /* starts the 16 MHz crystal oscillator */
#define CLOCK_STARTED REGISTER(0x40000100u)

#define TIMER(offset) REGISTER(0x40008000u + (offset))
#define TIMER_START TIMER(0x000u)
#define TIMER_CAPTURE(channel) TIMER(0x040u + 4u * (channel))
#define TIMER_COMPARE_EVENT(channel) TIMER(0x140u + 4u * (channel))
#define TIMER_INTERRUPT_ENABLE TIMER(0x304u)
#define TIMER_INTERRUPT_COMPARE(channel) (1u << (16u + (channel)))
#define TIMER_BIT_MODE TIMER(0x508u)
#define TIMER_BIT_MODE_32 3u
#define TIMER_PRESCALER TIMER(0x510u)
#define TIMER_PRESCALER_1_MHZ 4u
#define TIMER_COUNT(channel) TIMER(0x540u + 4u * (channel))

enum { CHANNEL_TICK, CHANNEL_NOW };

static volatile uint32_t tick_us; /* time of the last tick */

void clock_start(void) {
    CLOCK_STARTED = 0;
    CLOCK_START = 1;
    while (CLOCK_STARTED == 0) {
    }
    TIMER_BIT_MODE = TIMER_BIT_MODE_32;
    TIMER_PRESCALER = TIMER_PRESCALER_1_MHZ;
    TIMER_COUNT(CHANNEL_TICK) = CLOCK_TICK_US;
    TIMER_INTERRUPT_ENABLE = TIMER_INTERRUPT_COMPARE(CHANNEL_TICK);
    NVIC_SET_ENABLE(BOARD_TIMER_INTERRUPT) = NVIC_BIT(BOARD_TIMER_INTERRUPT);
    TIMER_START = 1;
}

/* All callers share one capture channel. Call this only from interrupt handlers, which do not preempt each other, or
 * with interrupts off. */
uint32_t clock_us(void) {
    TIMER_CAPTURE(CHANNEL_NOW) = 1;
    return TIMER_COUNT(CHANNEL_NOW);
}

void timer_handler(void) {
    TIMER_COMPARE_EVENT(CHANNEL_TICK) = 0;
    do { /* repeat if the next tick was already due when its time was set */
        if (clock_us() - tick_us >= CLOCK_TICK_US) {
            tick_us += CLOCK_TICK_US;
        }
        TIMER_COUNT(CHANNEL_TICK) = tick_us + CLOCK_TICK_US;
    } while (clock_us() - tick_us >= CLOCK_TICK_US);
    watchdog_check(tick_us);
}

uint32_t clock_tick_us(void) {
    return tick_us;
}
