/* comanip-pil: the simulated world in lockstep with a firmware image that runs elsewhere, for example in QEMU. */
#include <stdio.h>
#include <string.h>

#include "../port/remote_firmware.h"
#include "../run/run.h"

#define PROGRAM "comanip-pil"

static const char *serial;

static bus_t *create_bus(can_profile_t profile, char error[], size_t error_size) {
    if (!remote_firmware_open(serial, error, error_size)) {
        return NULL;
    }
    bus_t *bus = bus_create(profile);
    if (bus == NULL) {
        (void)snprintf(error, error_size, "not enough memory for the simulated world");
    }
    return bus;
}

static void run(world_t *world, const volatile sig_atomic_t *interrupted) {
    (void)interrupted; /* the world checks it each tick */
    remote_firmware_run(world);
}

int main(int argc, char *argv[]) {
    static const run_mode_t lockstep = {.program = PROGRAM, .create_bus = create_bus, .run = run};
    if (argc < 3 || strcmp(argv[1], "--serial") != 0) {
        return run_print_error(
            PROGRAM, "expected --serial PATH [options of comanip-sim]: `make pil` starts this program and QEMU");
    }
    serial = argv[2];
    argv[2] = argv[0];
    return run_main(&lockstep, argc - 2, argv + 2);
}
