/* Converts a CAN controller's timestamps to the clock of the kernel's timestamps.
 *
 * The controller stamps a frame on the bus, by its own clock with an arbitrary origin. The kernel stamps the frame when
 * it serves the interrupt, after a varying delay. The minimum difference of the two stamps over all frames is therefore
 * the offset between the clocks, and a frame's time is its hardware stamp plus this offset. The minimum is raised by
 * 1000 ppm of the elapsed time, so that an outdated minimum is not kept for ever. Two quartz clocks drift apart more
 * slowly than that (100 ppm), even while NTP slews one of them (500 ppm). */
#ifndef COMANIP_HARDWARE_CLOCK_H
#define COMANIP_HARDWARE_CLOCK_H

#include <stdbool.h>
#include <stdint.h>

/* If the difference of a frame's stamps exceeds the offset by more than this, one of the clocks has jumped: it was set,
 * or the controller's counter wrapped. */
#define HARDWARE_CLOCK_STEP_NS INT64_C(100000000)

/* Zero-initialise. */
typedef struct {
    bool has_offset;
    int64_t offset_ns;   /* minimum of the kernel's stamp minus the hardware's stamp */
    int64_t hardware_ns; /* hardware stamp of the last frame */
} hardware_clock_t;

/* Returns the time of the frame on the bus, by the kernel's clock. It is not later than the kernel's own stamp. */
int64_t hardware_clock_map(hardware_clock_t *self, int64_t hardware_ns, int64_t kernel_ns);

#endif
