/* comanip-sim: reads the command line, builds the world, runs the firmware in it, and reports. */
#include <ctype.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "../hal/host/hal_host.h"
#include "output/checks.h"
#include "options/help.h"
#include "options/options.h"
#include "output/output_folder.h"
#include "output/report.h"
#include "world.h"

#define EXIT_CHECK_FAILED 1
#define EXIT_WRONG_USE 2
#define EXIT_INTERRUPTED 130 /* 128 + SIGINT, as shells expect */

static volatile sig_atomic_t interrupted;

static void on_interrupt(int signal_number) {
    (void)signal_number;
    interrupted = 1;
}

/* Always one line: what came from the command line must not reach a terminal as a command. */
static int complain(const char *error, int status) {
    (void)fputs("comanip-sim: ", stderr);
    for (const char *character = error; *character != '\0'; character++) {
        (void)fputc(iscntrl((unsigned char)*character) ? '?' : *character, stderr);
    }
    (void)fputc('\n', stderr);
    return status;
}

static double wall_clock_s(void) {
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static hand_motion_t *load_motion(const options_t *options, char error[], size_t error_size) {
    if (options->tracker_path != NULL) {
        return hand_motion_create_recording(options->tracker_path, options->axes, error, error_size);
    }
    const scenario_t *scenario = options->scenario;
    (void)snprintf(error, error_size, "no memory for the motion");
    return hand_motion_create_legs(&scenario->hand_start, scenario->legs, scenario->leg_count);
}

static void print_result(const world_t *world, const checks_t *checks, const output_folder_t *folder, double wall_s) {
    if (!world->options->quiet) {
        report_end_progress(world);
        report_print_table(world, checks, wall_s);
        for (int i = 0; i < OUTPUT_COUNT; i++) {
            (void)printf("%s\n", folder->path[i]);
        }
        (void)printf("%s: %s: %s\n", world->options->scenario->name, report_verdict(checks->pass), checks->reason);
    } else if (!checks->pass) {
        (void)fprintf(stderr, "%s: FAIL: %s\n", world->options->scenario->name, checks->reason);
    }
}

/* Runs the world to its end and writes its files. Gives the exit status. */
static int run(const options_t *options, const hand_motion_t *motion, output_folder_t *folder) {
    char error[OPTIONS_ERROR_BYTES];
    static world_t world;
    static checks_t checks;
    if (!world_init(&world, options, motion, folder->partial_path[OUTPUT_BUS_LOG], folder->partial_path[OUTPUT_TRACE],
                    &interrupted, error, sizeof error)) {
        return complain(error, EXIT_CHECK_FAILED);
    }
    world.on_tick = options->quiet ? NULL : report_progress;
    const double start_s = wall_clock_s();
    hal_host_run(&world);
    const double wall_s = wall_clock_s() - start_s;
    checks_evaluate(&checks, &world);
    const bool written =
        world_close_files(&world, folder->partial_path[OUTPUT_TRACE], error, sizeof error) &&
        report_write_summary(&world, &checks, wall_s, folder->partial_path[OUTPUT_SUMMARY], error, sizeof error) &&
        output_folder_commit(folder, error, sizeof error);
    if (written) {
        print_result(&world, &checks, folder, wall_s);
    }
    world_free(&world);
    if (!written) {
        return complain(error, EXIT_CHECK_FAILED);
    }
    return interrupted != 0 ? EXIT_INTERRUPTED : checks.pass ? EXIT_SUCCESS : EXIT_CHECK_FAILED;
}

int main(int argc, char *argv[]) {
    char error[OPTIONS_ERROR_BYTES];
    static options_t options;
    switch (options_parse(&options, argc, argv, error)) {
    case OPTIONS_SHOW_HELP:
        help_print();
        return EXIT_SUCCESS;
    case OPTIONS_SHOW_SCENARIOS:
        help_print_scenarios();
        return EXIT_SUCCESS;
    case OPTIONS_WRONG:
        return complain(error, EXIT_WRONG_USE);
    case OPTIONS_RUN:
        break;
    }
    hand_motion_t *motion = load_motion(&options, error, sizeof error);
    if (motion == NULL) {
        return complain(error, EXIT_WRONG_USE);
    }
    output_folder_t folder;
    int status = EXIT_WRONG_USE;
    const double stop_s = world_duration_s(&options, motion) - SCENARIO_STOP_BEFORE_END_S;
    if (options.operator.clutch_s >= stop_s) {
        (void)snprintf(error, sizeof error, "--clutch '%g': expected less than %g s, where the operator stops",
                       options.operator.clutch_s, stop_s);
        hand_motion_destroy(motion);
        return complain(error, EXIT_WRONG_USE);
    }
    if (output_folder_open(&folder, options.out, error, sizeof error)) {
        /* Not signal(), after which a second signal would kill: `timeout` and some shells send two. */
        const struct sigaction action = {.sa_handler = on_interrupt};
        (void)sigaction(SIGINT, &action, NULL);
        (void)sigaction(SIGTERM, &action, NULL);
        if (!options.quiet && options.tracker_path != NULL) {
            (void)printf("%s\n", hand_motion_description(motion));
        }
        status = run(&options, motion, &folder);
    } else {
        (void)complain(error, EXIT_WRONG_USE);
    }
    output_folder_free(&folder);
    hand_motion_destroy(motion);
    return status;
}
