/* A CAN controller's time stamps, by the clock of the kernel's.
 *
 * The controller stamps a frame on the bus, by a clock of its own that starts anywhere; the kernel stamps it when the
 * interrupt is served, which is later by a delay that varies. So the least offset between the two, of all frames, is
 * that of the clocks: a frame's time is its hardware stamp plus it. The least offset creeps up by 1000 ppm, which is
 * more than two quartzes drift apart (100 ppm) while NTP slews one of them (500 ppm), so that no old minimum is kept
 * for ever. */
#ifndef COMANIP_HARDWARE_CLOCK_H
#define COMANIP_HARDWARE_CLOCK_H

#include <stdbool.h>
#include <stdint.h>

/* An offset that is larger by so much is that of other clocks: one of them was set, or the controller's counter
 * wrapped. */
#define HARDWARE_CLOCK_STEP_NS INT64_C(100000000)

/* Zero-initialise. */
typedef struct {
    bool has_offset;
    int64_t offset_ns;   /* the least, kernel's less hardware's */
    int64_t hardware_ns; /* of the last frame */
} hardware_clock_t;

/* When the frame was on the bus, by the kernel's clock: not after the kernel's own stamp. */
int64_t hardware_clock_map(hardware_clock_t *self, int64_t hardware_ns, int64_t kernel_ns);

#endif
