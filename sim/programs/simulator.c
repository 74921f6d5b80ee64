/* comanip-sim: the firmware in the simulated world, in lockstep and virtual time. */
#include <stdio.h>

#include "../port/local_firmware.h"
#include "../run/live.h"
#include "../run/run.h"

static bus_t *create_bus(can_profile_t profile, char error[], size_t error_size) {
    bus_t *bus = bus_create(profile);
    if (bus == NULL) {
        (void)snprintf(error, error_size, "not enough memory for the simulated world");
    }
    return bus;
}

static void run(world_t *world, const volatile sig_atomic_t *interrupted) {
    (void)interrupted; /* the world checks it each tick */
    static live_t live;
    char error[OPTIONS_ERROR_BYTES];
    if (!live_open(&live, world, error, sizeof error)) {
        world_fail(world, error);
        return;
    }
    local_firmware_run(world);
    live_close(&live);
}

int main(int argc, char *argv[]) {
    static const run_mode_t lockstep = {
        .program = "comanip-sim", .is_watchable = true, .create_bus = create_bus, .run = run};
    return run_main(&lockstep, argc, argv);
}
