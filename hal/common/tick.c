/* The HAL's tick for ports whose timer interrupts at each one: clock.h. */
#include <board.h> /* the image's, by its -I: the interrupt mask and wait_for_interrupt() */

#include "../hal.h"
#include "clock.h"

static uint32_t given_us; /* the tick that hal_wait_tick() gave last */

bool hal_wait_tick(uint32_t *now_us) {
    /* With interrupts off a tick cannot slip in between the question and the sleep; it still ends the sleep. */
    interrupts_off();
    while (clock_tick_us() == given_us) {
        wait_for_interrupt();
        interrupts_on();
        interrupts_off();
    }
    given_us = clock_tick_us();
    interrupts_on();
    *now_us = given_us;
    return true;
}
