#include "hardware_clock.h"

#define CREEP_INVERSE 1000 /* 1000 ppm */

int64_t hardware_clock_map(hardware_clock_t *self, int64_t hardware_ns, int64_t kernel_ns) {
    const int64_t offset_ns = kernel_ns - hardware_ns;
    const int64_t elapsed_ns = hardware_ns - self->hardware_ns; /* negative after a wrap or for reordered frames */
    const int64_t least_ns = self->offset_ns + (elapsed_ns > 0 ? elapsed_ns / CREEP_INVERSE : 0);
    const bool is_new = !self->has_offset || offset_ns < least_ns || offset_ns > least_ns + HARDWARE_CLOCK_STEP_NS;
    *self =
        (hardware_clock_t){.has_offset = true, .offset_ns = is_new ? offset_ns : least_ns, .hardware_ns = hardware_ns};
    return hardware_ns + self->offset_ns;
}
