/* The common part of the programs that run a scenario: command line, world, files and report. The programs differ in
 * the bus that they use and in what advances the time. */
#ifndef COMANIP_SIM_RUN_H
#define COMANIP_SIM_RUN_H

#include <signal.h>
#include <stdbool.h>

#include "../world/world.h"

typedef struct {
    const char *program; /* name, printed before each error */
    bool is_watchable;   /* accepts --hub and --real-time (live.h) */
    bus_t *(*create_bus)(can_profile_t profile, char error[], size_t error_size);
    /* Runs the world to its end. */
    void (*run)(world_t *world, const volatile sig_atomic_t *interrupted);
} run_mode_t;

/* Does the work of main() in each program that runs a scenario. Returns the exit status. */
int run_main(const run_mode_t *mode, int argc, char *argv[]);

/* Prints an error on one line. Returns the exit status for incorrect usage. */
int run_print_error(const char *program, const char *error);

#endif
