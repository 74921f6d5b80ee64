/* Converts a CAN controller's time stamps to the clock of the kernel's.
 *
 * The controller stamps a frame on the bus, on its own clock with an arbitrary origin; the kernel stamps it when the
 * interrupt is served, after a varying delay. The minimum offset between the two over all frames is therefore that of
 * the clocks, and a frame's time is its hardware stamp plus this offset. The minimum is raised by 1000 ppm of the time
 * elapsed, so that an old one is not kept for ever: two quartzes drift apart less (100 ppm), even while NTP slews one
 * of them (500 ppm). */
#ifndef COMANIP_HARDWARE_CLOCK_H
#define COMANIP_HARDWARE_CLOCK_H

#include <stdbool.h>
#include <stdint.h>

/* An offset larger by this much belongs to changed clocks: one of them was set, or the controller's counter wrapped. */
#define HARDWARE_CLOCK_STEP_NS INT64_C(100000000)

/* Zero-initialise. */
typedef struct {
    bool has_offset;
    int64_t offset_ns;   /* the minimum of kernel's minus hardware's */
    int64_t hardware_ns; /* of the last frame */
} hardware_clock_t;

/* Time of the frame on the bus, on the kernel's clock: not later than the kernel's own stamp. */
int64_t hardware_clock_map(hardware_clock_t *self, int64_t hardware_ns, int64_t kernel_ns);

#endif
