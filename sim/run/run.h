/* What the programs that run a scenario share: the command line, the world, its files, the report. They differ in the
 * bus and in what makes time go on. */
#ifndef COMANIP_SIM_RUN_H
#define COMANIP_SIM_RUN_H

#include <signal.h>
#include <stdbool.h>

#include "../world/world.h"

typedef struct {
    const char *program; /* its name, before every complaint */
    bool is_watchable;   /* takes --hub and --real-time (live.h) */
    bus_t *(*create_bus)(can_profile_t profile, char error[], size_t error_size);
    /* Runs the world to its end. */
    void (*run)(world_t *world, const volatile sig_atomic_t *interrupted);
} run_mode_t;

/* main() of such a program: gives the exit status. */
int run_main(const run_mode_t *mode, int argc, char *argv[]);

/* Says what is wrong in one line. Gives the exit status for wrong use. */
int run_complain(const char *program, const char *error);

#endif
