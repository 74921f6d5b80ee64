/* comanip-plant: the simulated world without the firmware, on a real bus and in real time. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../firmware/protocol/can_transport.h"
#include "../../hal/linux/pace.h"
#include "../../hal/linux/run_options.h"
#include "../bus/live_bus.h"
#include "../options/options.h"
#include "../run/run.h"

#define PROGRAM "comanip-plant"
#define PRIORITY 70 /* below the firmware's priority */

static const char usage[] =
    "comanip-plant: arm, drives, gripper, tracker, operator and people, simulated in real time on a CAN bus; the "
    "firmware\n"
    "runs as a separate process\n"
    "\n"
    "usage: build/linux/comanip-plant --can NAME [--slow N] [options of comanip-sim]\n"
    "       make run-plant CAN=NAME SCENARIO=pour ...\n"
    "\n"
    "  --can NAME   the kernel's CAN interface, for example can0 or vcan0; if it does not exist, the hub of this "
    "name\n"
    "  --slow N     time scale: 1 ms of simulated time takes N ms, 1 (default) to 1000; the firmware needs the same "
    "value\n"
    "\n"
    "The plant waits for the firmware's first JointCmd. Under real_time, summary.json reports the late ticks.\n"
    "\n";

static run_options_t options;

static bus_t *create_bus(can_profile_t profile, char error[], size_t error_size) {
    return live_bus_create(PROGRAM, options.can, profile, options.slow, error, error_size);
}

static void run(world_t *world, const volatile sig_atomic_t *interrupted) {
    static live_bus_timing_t timing;
    pace_make_real_time(PROGRAM, PRIORITY);
    (void)printf(PROGRAM ": waits for the firmware on %s\n", options.can);
    (void)fflush(stdout);
    if (live_bus_start(world->bus, transport_first_id(bus_profile(world->bus), FRAME_JOINT_CMD), interrupted)) {
        (void)printf(PROGRAM ": the firmware has started\n");
        (void)fflush(stdout);
        while (world_advance(world)) {
        }
    } else {
        world_fail(world, "interrupted while waiting for the firmware");
    }
    timing = live_bus_timing(world->bus);
    world->timing = &timing;
}

int main(int argc, char *argv[]) {
    static const run_mode_t real_time = {.program = PROGRAM, .create_bus = create_bus, .run = run};
    char error[OPTIONS_ERROR_BYTES];
    if (!run_options_take(&options, &argc, argv, error, sizeof error)) {
        return run_print_error(PROGRAM, error);
    }
    if (argc > 1 && (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0)) {
        (void)fputs(usage, stdout); /* run_main() then prints the simulator's help */
    } else if (options.can == NULL) {
        return run_print_error(PROGRAM, "expected --can NAME, for example --can vcan0; see --help");
    }
    return run_main(&real_time, argc, argv);
}
