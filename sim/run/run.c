/* Reads the command line, builds the world, runs it, and reports. */
#include "run.h"

#include <ctype.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "../feasibility/scenario_geometry.h"
#include "../options/help.h"
#include "../options/options.h"
#include "../output/checks.h"
#include "../output/output_folder.h"
#include "../output/reason.h"
#include "../output/report.h"
#include "../output/run_files.h"
#include "../scenario/scenario_file.h"

#define EXIT_CHECK_FAILED 1
#define EXIT_WRONG_USE 2
#define EXIT_INTERRUPTED 130 /* 128 + SIGINT, as shells expect */
#define PATH_BYTES 4096
#define SCENARIO_FOLDER "/../../sim/scenarios" /* relative to the programs in build/host/ and build/linux/ */

static volatile sig_atomic_t interrupted;

static void on_interrupt(int signal_number) {
    (void)signal_number;
    interrupted = 1;
}

/* Prints one line, with '?' in place of control characters, because text from the command line must not reach the
 * terminal as control codes. Returns `status`. */
static int print_error(const char *program, const char *error, int status) {
    (void)fprintf(stderr, "%s: ", program);
    for (const char *character = error; *character != '\0'; character++) {
        (void)fputc(iscntrl((unsigned char)*character) ? '?' : *character, stderr);
    }
    (void)fputc('\n', stderr);
    return status;
}

int run_print_error(const char *program, const char *error) {
    return print_error(program, error, EXIT_WRONG_USE);
}

static double wall_clock_s(void) {
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Derives the folder of the project's scenarios from the program's own path, so that the working directory does not
 * matter. */
static void find_scenario_folder(char folder[PATH_BYTES]) {
    const ssize_t bytes = readlink("/proc/self/exe", folder, PATH_BYTES - sizeof SCENARIO_FOLDER);
    folder[bytes > 0 ? bytes : 0] = '\0';
    char *slash = strrchr(folder, '/');
    (void)strcpy(slash != NULL ? slash : folder, SCENARIO_FOLDER);
}

static bool load_scenario(scenario_t *scenario, const options_t *options, const char *folder, char error[],
                          size_t error_size) {
    if (!scenario_load(scenario, options->scenario, folder, error, error_size) ||
        !scenario_check_geometry(scenario, error, error_size) || !scenario_check_water(scenario, error, error_size)) {
        return false;
    }
    scenario_vary(scenario, options->seed);
    if (!scenario_check_geometry(scenario, error, error_size)) {
        return false;
    }
    const bool is_shortened = options->duration_s > 0.0 && options->duration_s < scenario->duration_s;
    const double stop_s = (is_shortened ? options->duration_s : scenario->duration_s) - SCENARIO_STOP_BEFORE_END_S;
    if (options->operator.clutch_s >= stop_s) {
        (void)snprintf(error, error_size, "--clutch '%g': expected less than %g s, when the operator stops the arm",
                       options->operator.clutch_s, stop_s);
        return false;
    }
    if (options->second_path != NULL && scenario->person_count < 2) {
        (void)snprintf(error, error_size, "--tracker-second '%.200s': expected a scenario with two people; %s has one",
                       options->second_path, scenario->name);
        return false;
    }
    return true;
}

static void print_result(const world_t *world, const checks_t *checks, const output_folder_t *folder, double wall_s) {
    if (!world->options->quiet) {
        report_end_progress(world);
        report_print_table(world, checks, wall_s);
        for (int i = 0; i < OUTPUT_COUNT; i++) {
            (void)printf("%s\n", folder->path[i]);
        }
        (void)printf("%s: %s: %s\n", world->scenario->name, report_verdict(checks->pass), checks->reason);
    } else if (!checks->pass) {
        (void)fprintf(stderr, "%s: FAIL: %s\n", world->scenario->name, checks->reason);
    }
}

static void on_tick(void *context, const world_t *world) {
    run_files_write_tick(context, world);
    if (!world->options->quiet) {
        report_progress(world);
    }
}

/* Runs the world to its end and writes its files. Returns the exit status. */
static int run(const run_mode_t *mode, world_t *world, output_folder_t *folder) {
    char error[OPTIONS_ERROR_BYTES];
    static checks_t checks;
    static run_files_t files;
    if (!run_files_open(&files, world, folder->partial_path[OUTPUT_BUS_LOG], folder->partial_path[OUTPUT_TRACE], error,
                        sizeof error)) {
        return print_error(mode->program, error, EXIT_CHECK_FAILED);
    }
    world->on_tick = on_tick;
    world->on_tick_context = &files;
    const double start_s = wall_clock_s();
    mode->run(world, &interrupted);
    const double wall_s = wall_clock_s() - start_s;
    checks_evaluate(&checks, world);
    reason_write(&checks, world);
    if (!run_files_close(&files, folder->partial_path[OUTPUT_TRACE], error, sizeof error) ||
        !report_write_summary(world, &checks, wall_s, folder->partial_path[OUTPUT_SUMMARY], error, sizeof error) ||
        !output_folder_commit(folder, error, sizeof error)) {
        return print_error(mode->program, error, EXIT_CHECK_FAILED);
    }
    print_result(world, &checks, folder, wall_s);
    return interrupted != 0 ? EXIT_INTERRUPTED : checks.pass ? EXIT_SUCCESS : EXIT_CHECK_FAILED;
}

/* Opens the output folder and runs the world. The folder is opened after all other checks, so that a wrong option does
 * not remove the results of an earlier run. */
static int open_folder_and_run(const run_mode_t *mode, world_t *world) {
    char error[OPTIONS_ERROR_BYTES];
    char default_out[sizeof "out/" + SCENARIO_NAME_BYTES];
    (void)snprintf(default_out, sizeof default_out, "out/%s", world->scenario->name);
    const char *out = world->options->out != NULL ? world->options->out : default_out;
    output_folder_t folder;
    int status = EXIT_WRONG_USE;
    if (output_folder_open(&folder, out, error, sizeof error)) {
        /* sigaction() rather than signal(): the handler must stay installed, because `timeout` and some shells send the
         * signal twice. */
        const struct sigaction action = {.sa_handler = on_interrupt};
        (void)sigaction(SIGINT, &action, NULL);
        (void)sigaction(SIGTERM, &action, NULL);
        for (size_t i = 0; i < world->scenario->person_count && !world->options->quiet; i++) {
            const char *description = person_program_description(world->program[i]);
            (void)printf("%s%s", description, description[0] != '\0' ? "\n" : "");
        }
        status = run(mode, world, &folder);
    } else {
        (void)run_print_error(mode->program, error);
    }
    output_folder_free(&folder);
    return status;
}

/* Builds the world and runs it. The bus is opened first, so that a wrong bus name is reported at once. */
static int build_and_run(const run_mode_t *mode, const options_t *options, const scenario_t *scenario) {
    char error[OPTIONS_ERROR_BYTES];
    static world_t world;
    bus_t *bus = mode->create_bus(options->profile, error, sizeof error);
    if (bus == NULL) {
        return run_print_error(mode->program, error);
    }
    const bool is_ready = world_init(&world, options, scenario, bus, &interrupted, error, sizeof error);
    const int status = is_ready ? open_folder_and_run(mode, &world) : run_print_error(mode->program, error);
    world_free(&world);
    return status;
}

int run_main(const run_mode_t *mode, int argc, char *argv[]) {
    char error[OPTIONS_ERROR_BYTES];
    char scenario_folder[PATH_BYTES];
    static options_t options;
    static scenario_t scenario;
    find_scenario_folder(scenario_folder);
    switch (options_parse(&options, argc, argv, error)) {
    case OPTIONS_SHOW_HELP: help_print(); return EXIT_SUCCESS;
    case OPTIONS_SHOW_SCENARIOS:
        return help_print_scenarios(scenario_folder, error, sizeof error) ? EXIT_SUCCESS
                                                                          : run_print_error(mode->program, error);
    case OPTIONS_WRONG: return run_print_error(mode->program, error);
    case OPTIONS_RUN: break;
    }
    if (!mode->is_watchable && (options.hub != NULL || options.real_time)) {
        return run_print_error(mode->program, "--hub, --real-time: only comanip-sim accepts these options");
    }
    if (!load_scenario(&scenario, &options, scenario_folder, error, sizeof error)) {
        return run_print_error(mode->program, error);
    }
    return build_and_run(mode, &options, &scenario);
}
