#include "report.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "../common/names.h"
#include "json_writer.h"
#include "summary_scene.h"

#define PROGRESS_TERMINAL_TICKS 500
#define LATENCY_TEXT_BYTES 120
#define PROGRESS_LINES 4 /* progress lines per run if the output is not a terminal */

static double simulated_s(const world_t *world) {
    return (double)world->now_ns * 1e-9;
}

static void write_followable(json_writer_t *json, const tracking_sums_t *sums) {
    const bool measured = sums->ticks > 0;
    if (!measured) {
        json_null(json, "followable");
        return;
    }
    json_begin(json, "followable", '{');
    json_number(json, "s", (double)sums->ticks * WORLD_TICK_NS * 1e-9);
    json_number(json, "rms_position_mm", tracking_rms_position_mm(sums));
    json_number(json, "rms_orientation_deg", tracking_rms_orientation_deg(sums));
    json_end(json, '}');
}

static void write_tracking(json_writer_t *json, const world_t *world) {
    const tracking_sums_t *sums = &world->tracking.all;
    const bool measured = checks_tracking_measured(world);
    json_begin(json, "tracking", '{');
    json_number(json, "rms_position_mm", measured ? tracking_rms_position_mm(sums) : (double)NAN);
    json_number(json, "max_position_mm", measured ? sums->max_position_mm : (double)NAN);
    json_number(json, "rms_orientation_deg", measured ? tracking_rms_orientation_deg(sums) : (double)NAN);
    json_number(json, "max_orientation_deg", measured ? sums->max_orientation_deg : (double)NAN);
    write_followable(json, &world->tracking.followable);
    json_end(json, '}');
    json_begin(json, "reach", '{');
    json_number(json, "out_of_reach_s",
                measured ? (double)world->tracking.out_of_reach_ticks * WORLD_TICK_NS * 1e-9 : (double)NAN);
    json_end(json, '}');
}

/* Writes the longest time for which hand and task were still, and the joint speed that remained. If the speed was not
 * measured, writes the reason. */
static void write_rest(json_writer_t *json, const rest_monitor_t *rest, const char *not_measured) {
    json_begin(json, "rest", '{');
    json_number(json, "still_s", rest->longest_s);
    json_number(json, "speed_radps", rest->measured ? rest->speed_radps_max : (double)NAN);
    if (not_measured[0] != '\0') {
        json_text(json, "not_measured", not_measured);
    } else {
        json_null(json, "not_measured");
    }
    json_end(json, '}');
}

/* A row of the latency table: one component of the end effector's latency or, in the last row, the total latency. */
typedef struct {
    const char *name, *key, *how;
    double ms;
} latency_row_t;

#define LATENCY_ROWS 7

static void list_latency(const latency_ms_t *latency, latency_row_t row[LATENCY_ROWS]) {
    const latency_row_t rows[LATENCY_ROWS] = {
        {"tracker", "tracker_ms", "announced", latency->tracker},
        {"bus", "bus_ms", "measured", latency->bus},
        {"estimate", "estimate_ms", "measured", latency->estimate},
        {"law", "law_ms", "computed", latency->law},
        {"command bus", "command_bus_ms", "measured", latency->command},
        {"drive", "drive_ms", "assumed", latency->drive},
        {"end to end", "end_to_end_ms", "measured", latency->end_to_end},
    };
    memcpy(row, rows, sizeof rows);
}

/* Fills `text` with the reason why the latency was not measured; "" if it was. */
static void why_latency_not_measured(const world_t *world, char text[LATENCY_TEXT_BYTES]) {
    const latency_ms_t *latency = &world->latency_ms;
    text[0] = '\0';
    if (world->observer.parameter[PARAMETER_TRACE] <= 0.0f) {
        (void)snprintf(text, LATENCY_TEXT_BYTES, "it needs the target, but the trace is switched off");
    } else if (latency->moved_s < LATENCY_NEEDED_S) {
        (void)snprintf(text, LATENCY_TEXT_BYTES,
                       "the arm could follow %.2f s of the hand's motion, and %g s are needed", latency->moved_s,
                       LATENCY_NEEDED_S);
    } else if (isnan(latency->end_to_end) || isnan(latency->estimate)) {
        (void)snprintf(text, LATENCY_TEXT_BYTES, "no delay between %d and %d ms fits the motion", DELAY_FIRST_TICKS,
                       DELAY_LAST_TICKS);
    }
}

static void write_latency(json_writer_t *json, const world_t *world) {
    latency_row_t row[LATENCY_ROWS];
    char why[LATENCY_TEXT_BYTES];
    list_latency(&world->latency_ms, row);
    why_latency_not_measured(world, why);
    json_begin(json, "latency", '{');
    for (int i = 0; i < LATENCY_ROWS; i++) {
        json_number(json, row[i].key, row[i].ms);
    }
    json_begin(json, "how", '{');
    for (int i = 0; i < LATENCY_ROWS; i++) {
        json_text(json, row[i].key, isnan(row[i].ms) ? "not measured" : row[i].how);
    }
    json_end(json, '}');
    if (why[0] != '\0') {
        json_text(json, "not_measured", why);
    } else {
        json_null(json, "not_measured");
    }
    json_end(json, '}');
}

static void print_latency(const world_t *world) {
    latency_row_t row[LATENCY_ROWS];
    char why[LATENCY_TEXT_BYTES];
    list_latency(&world->latency_ms, row);
    why_latency_not_measured(world, why);
    (void)printf("latency [ms]:");
    for (int i = 0; i < LATENCY_ROWS; i++) {
        if (!isnan(row[i].ms)) {
            (void)printf("%s %s %.1f (%s)", i > 0 ? "," : "", row[i].name, row[i].ms, row[i].how);
        }
    }
    (void)printf("%s%s\n", why[0] != '\0' ? "; end to end not measured: " : "", why);
}

static double mean_load_percent(const world_t *world) {
    return world->now_ns > 0 ? 100.0 * (double)bus_statistics(world->bus).busy_ns / (double)world->now_ns : 0.0;
}

static void write_traffic(json_writer_t *json, const world_t *world) {
    const bus_statistics_t bus = bus_statistics(world->bus);
    const tracker_statistics_t tracker = tracker_node_statistics(world->tracker);
    json_begin(json, "limits", '{');
    json_unsigned(json, "violations", world->observer.limits.violations);
    json_end(json, '}');
    json_begin(json, "bus", '{');
    json_unsigned(json, "frames", bus.frames);
    json_number(json, "load_percent_mean", mean_load_percent(world));
    json_number(json, "load_percent_peak", bus.load_percent_peak);
    json_unsigned(json, "dropped", bus.dropped + world->firmware_overflows);
    json_text(json, "profile", bus_profile(world->bus) == CAN_PROFILE_CLASSIC ? "classic" : "fd");
    json_end(json, '}');
    json_begin(json, "tracker", '{');
    json_unsigned(json, "samples", tracker.samples);
    json_unsigned(json, "lost", tracker.lost);
    json_unsigned(json, "range_errors", tracker.range_errors);
    json_number(json, "longest_gap_ms", 1e3 * tracker.longest_gap_s);
    json_end(json, '}');
}

static void write_modes(json_writer_t *json, const observer_t *observer) {
    json_begin(json, "modes", '[');
    for (size_t i = 0; i < observer->mode_count; i++) {
        const mode_change_t *change = &observer->modes[i];
        json_begin(json, NULL, '{');
        json_number(json, "t_s", change->t_s);
        json_text(json, "mode", mode_name((uint8_t)change->mode));
        json_text(json, "reason", reason_name((uint8_t)change->reason));
        json_end(json, '}');
    }
    json_end(json, ']');
}

static void write_checks(json_writer_t *json, const checks_t *checks) {
    json_begin(json, "checks", '[');
    for (size_t i = 0; i < checks->count; i++) {
        const check_t *check = &checks->check[i];
        json_begin(json, NULL, '{');
        json_text(json, "name", check->name);
        json_number(json, "value", check->measured ? check->value : (double)NAN);
        json_number(json, "limit", check->limit);
        json_text(json, "unit", check->unit);
        json_bool(json, "pass", check->pass);
        if (check->measured && !isnan(check->orientation_rest_deg)) {
            json_number(json, "orientation_rms_deg", check->orientation_rest_deg);
        }
        json_end(json, '}');
    }
    json_end(json, ']');
}

/* Writes the timing of a run on a real bus. timing: NULL for a run in virtual time. */
static void write_timing(json_writer_t *json, const live_bus_timing_t *timing) {
    if (timing == NULL) {
        return;
    }
    json_begin(json, "real_time", '{');
    json_unsigned(json, "slow", timing->slow);
    json_unsigned(json, "overruns", timing->overruns);
    json_number(json, "late_max_ms", 1e-6 * (double)timing->late_max_ns);
    json_number(json, "let_go_ms", 1e-6 * (double)timing->set_back_ns);
    json_end(json, '}');
}

static void write_count(json_writer_t *json, const char *key, uint16_t count) {
    if (count == PORT_UNKNOWN) {
        json_null(json, key);
    } else {
        json_unsigned(json, key, count);
    }
}

/* Writes the content of the firmware's last PortStatus. */
static void write_port(json_writer_t *json, const observer_t *observer) {
    const port_status_t *port = &observer->port;
    if (!observer->has_port) {
        json_null(json, "port");
        return;
    }
    json_begin(json, "port", '{');
    json_text(json, "can_state", can_state_name((uint8_t)port->can_state));
    write_count(json, "refused_frames", port->refused_frames);
    write_count(json, "lost_frames", port->lost_frames);
    write_count(json, "error_passive", port->error_passive);
    write_count(json, "bus_off", port->bus_off);
    write_count(json, "missed_ticks", port->missed_ticks);
    write_count(json, "longest_tick_us", port->longest_tick_us);
    if (port->error_passive == PORT_UNKNOWN || port->longest_tick_us == PORT_UNKNOWN) {
        json_text(json, "not_measured", "the port does not measure the values that are null");
    } else {
        json_null(json, "not_measured");
    }
    json_end(json, '}');
}

bool report_write_summary(const world_t *world, const checks_t *checks, double wall_s, const char *path, char error[],
                          size_t error_size) {
    json_writer_t json = {.file = fopen(path, "w")};
    if (json.file == NULL) {
        (void)snprintf(error, error_size, "%s: cannot be written: %s", path, strerror(errno));
        return false;
    }
    json_begin(&json, NULL, '{');
    json_text(&json, "scenario", world->scenario->name);
    json_text(&json, "result", checks->pass ? "pass" : "fail");
    json_text(&json, "reason", checks->reason);
    json_unsigned(&json, "seed", world->options->seed);
    json_number(&json, "sim_s", simulated_s(world));
    json_number(&json, "wall_s", wall_s);
    json_unsigned(&json, "ticks", world->ticks);
    summary_write_setting(&json, world);
    write_tracking(&json, world);
    write_traffic(&json, world);
    write_modes(&json, &world->observer);
    summary_write_scene(&json, world);
    write_checks(&json, checks);
    write_timing(&json, world->timing);
    write_rest(&json, &world->rest, checks->rest_not_measured);
    write_latency(&json, world);
    write_port(&json, &world->observer);
    json_end(&json, '}');
    (void)fputc('\n', json.file);
    const bool failed = ferror(json.file) != 0;
    if (fclose(json.file) != 0 || failed) {
        (void)snprintf(error, error_size, "%s: not written completely: %s", path, strerror(errno));
        return false;
    }
    return true;
}

static bool is_terminal(void) {
    return isatty(STDOUT_FILENO) != 0;
}

const char *report_verdict(bool pass) {
    const char *no_colour = getenv("NO_COLOR"); /* switches colours off if set and not empty (no-color.org) */
    if (!is_terminal() || (no_colour != NULL && no_colour[0] != '\0')) {
        return pass ? "PASS" : "FAIL";
    }
    return pass ? "\033[32mPASS\033[0m" : "\033[31mFAIL\033[0m";
}

static void print_row(const check_t *check) {
    const int decimals = check->unit[0] == '\0' ? 0 : 2; /* counts have no unit */
    char value[32] = "not measured";
    if (check->measured) {
        (void)snprintf(value, sizeof value, "%.*f", decimals, check->value);
    }
    (void)printf("%-28s %14s %s %9.*f %-4s %s\n", check->name, value, check->is_lower_bound ? ">=" : "<=", decimals,
                 check->limit, check->unit, report_verdict(check->pass));
}

static void print_forces(const world_t *world) {
    for (size_t i = 0; i < world->scenario->person_count; i++) {
        const held_force_t *force = &world->contact_monitor.hand[i];
        if (force->ticks > 0) {
            (void)printf("force at the hand of %s while it holds an object: %.2f N RMS, %.2f N peak\n",
                         world->scenario->person[i].name, held_force_rms_N(force), held_force_peak_N(force));
        }
    }
}

static void print_water(const world_t *world) {
    const water_count_t *water = &world->state.water;
    if (world->scenario->water.particles > 0) {
        (void)printf("water: %d of %d particles left the robot's cup; %d in the person's cup, %d elsewhere\n",
                     water->left_robot_cup, world->scenario->water.particles, water->in_person_cup, water->elsewhere);
    }
}

static void print_least(const world_t *world, const char *what, const least_clearance_t *least) {
    if (least->pair >= 0) {
        (void)printf("least clearance %s: %.1f mm at %.2f s (%s)\n", what, 1e3 * least->least_m, least->t_s,
                     proximity_pair_name(world->proximity, least->pair));
    }
}

static void print_scene(const world_t *world) {
    print_forces(world);
    print_water(world);
    print_least(world, "between person and robot", &world->contact_monitor.person);
    print_least(world, "between the arm and the rest of the robot", &world->contact_monitor.self);
}

static void print_timing(const live_bus_timing_t *timing) {
    if (timing != NULL) {
        (void)printf("real time (time scale %u): %" PRIu64 " ticks more than one tick late; largest delay %.2f ms%s\n",
                     timing->slow, timing->overruns, 1e-6 * (double)timing->late_max_ns,
                     timing->set_back_ns > 0 ? "; the clock was set back" : "");
    }
}

void report_print_table(const world_t *world, const checks_t *checks, double wall_s) {
    (void)printf("%-28s %14s    %9s %-4s\n", "check", "value", "limit", "unit");
    for (size_t i = 0; i < checks->count; i++) {
        print_row(&checks->check[i]);
    }
    if (checks->rest_not_measured[0] != '\0') {
        (void)printf("%-28s %14s    not measured (%s)\n", "comes_to_rest", "-", checks->rest_not_measured);
    }
    if (checks->tracking_not_judged) {
        (void)printf("%-28s %14s    not judged (the arm could follow for %.2f s, and the check needs %g s)\n",
                     "followable_rms_position", "-", (double)world->tracking.followable.ticks * WORLD_TICK_NS * 1e-9,
                     CHECKS_FOLLOWABLE_MIN_S);
    }
    if (checks_tracking_measured(world)) {
        const tracking_sums_t *sums = &world->tracking.all;
        (void)printf("tracking during the whole cooperation: %.2f mm RMS, %.2f mm max; %.2f deg RMS, %.2f deg max; "
                     "target out of reach for %.2f s, followable for %.2f s\n",
                     tracking_rms_position_mm(sums), sums->max_position_mm, tracking_rms_orientation_deg(sums),
                     sums->max_orientation_deg, (double)world->tracking.out_of_reach_ticks * WORLD_TICK_NS * 1e-9,
                     (double)world->tracking.followable.ticks * WORLD_TICK_NS * 1e-9);
    }
    print_scene(world);
    print_latency(world);
    print_timing(world->timing);
    (void)printf("bus: %.1f %% load, %.1f %% peak; %.2f s simulated in %.2f s (%.3g times real time)\n",
                 mean_load_percent(world), bus_statistics(world->bus).load_percent_peak, simulated_s(world), wall_s,
                 wall_s > 0.0 ? simulated_s(world) / wall_s : 0.0);
}

void report_progress(const world_t *world) {
    const uint64_t total = (uint64_t)(world->end_ns / WORLD_TICK_NS);
    const size_t changes = world->observer.mode_count;
    const char *mode = changes > 0 ? mode_name((uint8_t)world->observer.modes[changes - 1].mode) : "boot";
    const double longest_s = (double)world->end_ns * 1e-9; /* only an upper limit: a run ends when its scripts end */
    if (is_terminal()) {
        if (world->ticks % PROGRESS_TERMINAL_TICKS == 0 || world->ticks == total) {
            (void)printf("\r%s %5.1f s of at most %.1f s  %-12s%s", world->scenario->name, simulated_s(world),
                         longest_s, mode, world->ticks == total ? "\n" : "");
            (void)fflush(stdout);
        }
    } else if (world->ticks * PROGRESS_LINES % total < PROGRESS_LINES) {
        (void)printf("%s %.1f s of at most %.1f s  %s\n", world->scenario->name, simulated_s(world), longest_s, mode);
        (void)fflush(stdout);
    }
}

void report_end_progress(const world_t *world) {
    const bool is_line_open = world->ticks >= PROGRESS_TERMINAL_TICKS && world->now_ns < world->end_ns;
    if (is_terminal() && is_line_open) {
        (void)putchar('\n');
    }
}
