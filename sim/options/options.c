#include "options.h"

#include <getopt.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "../../firmware/protocol/can_transport.h"
#include "../../hal/linux/hub_path.h"
#include "option_values.h"

#define UNIT_TOLERANCE 1e-3 /* largest deviation of a quaternion's norm from 1 */
#define MOUNT_MAX_M 1e3
#define PAPER_GAIN_PER_S 4.0f /* the paper does not state a value; its law uses one gain for all components */

enum {
    OPTION_SCENARIO = 256,
    OPTION_TRACKER,
    OPTION_TRACKER_SECOND,
    OPTION_AXES,
    OPTION_SEED,
    OPTION_OUT,
    OPTION_DURATION,
    OPTION_PHYSICS_STEP,
    OPTION_RATE,
    OPTION_NOISE_MM,
    OPTION_NOISE_DEG,
    OPTION_LATENCY_MS,
    OPTION_MOUNT_TRANSLATION,
    OPTION_MOUNT_ROTATION,
    OPTION_DROPOUT,
    OPTION_GAP,
    OPTION_TRACKER_CLOCK,
    OPTION_SCALE,
    OPTION_PARAM,
    OPTION_PAPER_LAW,
    OPTION_DEFINE,
    OPTION_CLUTCH,
    OPTION_PROFILE,
    OPTION_HUB,
    OPTION_REAL_TIME,
    OPTION_QUIET,
    OPTION_LIST,
    OPTION_HELP,
};

static const struct option option_table[] = {
    {"scenario", required_argument, NULL, OPTION_SCENARIO},
    {"tracker", required_argument, NULL, OPTION_TRACKER},
    {"tracker-second", required_argument, NULL, OPTION_TRACKER_SECOND},
    {"axes", required_argument, NULL, OPTION_AXES},
    {"seed", required_argument, NULL, OPTION_SEED},
    {"out", required_argument, NULL, OPTION_OUT},
    {"duration", required_argument, NULL, OPTION_DURATION},
    {"physics-step-us", required_argument, NULL, OPTION_PHYSICS_STEP},
    {"rate", required_argument, NULL, OPTION_RATE},
    {"noise-mm", required_argument, NULL, OPTION_NOISE_MM},
    {"noise-deg", required_argument, NULL, OPTION_NOISE_DEG},
    {"latency-ms", required_argument, NULL, OPTION_LATENCY_MS},
    {"mount-translation", required_argument, NULL, OPTION_MOUNT_TRANSLATION},
    {"mount-rotation", required_argument, NULL, OPTION_MOUNT_ROTATION},
    {"dropout", required_argument, NULL, OPTION_DROPOUT},
    {"gap", required_argument, NULL, OPTION_GAP},
    {"tracker-clock", required_argument, NULL, OPTION_TRACKER_CLOCK},
    {"scale", required_argument, NULL, OPTION_SCALE},
    {"param", required_argument, NULL, OPTION_PARAM},
    {"paper-law", no_argument, NULL, OPTION_PAPER_LAW},
    {"define", required_argument, NULL, OPTION_DEFINE},
    {"clutch", required_argument, NULL, OPTION_CLUTCH},
    {"profile", required_argument, NULL, OPTION_PROFILE},
    {"hub", required_argument, NULL, OPTION_HUB},
    {"real-time", no_argument, NULL, OPTION_REAL_TIME},
    {"quiet", no_argument, NULL, OPTION_QUIET},
    {"list", no_argument, NULL, OPTION_LIST},
    {"help", no_argument, NULL, OPTION_HELP},
    {NULL, 0, NULL, 0},
};

/* Options that take one number. member: offset of the member of options_t that the option sets. unit: factor from the
 * option's unit to the member's unit. */
static const struct {
    int option;
    size_t member;
    double unit, minimum, maximum;
    const char *expected;
} number_table[] = {
    {OPTION_DURATION, offsetof(options_t, duration_s), 1.0, 2.0, 86400.0, "a number of seconds from 2 to 86400"},
    {OPTION_RATE, offsetof(options_t, tracker.rate_hz), 1.0, 15.0, 1000.0, "a number of Hz from 15 to 1000"},
    {OPTION_NOISE_MM, offsetof(options_t, tracker.noise_position_m), 1e-3, 0.0, 1000.0,
     "a standard deviation in mm from 0 to 1000"},
    {OPTION_NOISE_DEG, offsetof(options_t, tracker.noise_rotation_rad), ROBOT_RAD_PER_DEG, 0.0, 57.0,
     "a standard deviation in degrees from 0 to 57"},
    {OPTION_LATENCY_MS, offsetof(options_t, tracker.latency_s), 1e-3, 0.0, 500.0, "a number of ms from 0 to 500"},
    {OPTION_CLUTCH, offsetof(options_t, operator.clutch_s), 1.0, OPERATOR_SCRIPT_CLUTCH_MIN_S, 86400.0,
     "a number of seconds from 1 to 86400"},
    {OPTION_DROPOUT, offsetof(options_t, tracker.dropout_probability), 1.0, 0.0, 1.0, "a probability from 0 to 1"},
};

static bool wrong(char error[], const char *option, const char *value, const char *expected) {
    (void)snprintf(error, OPTIONS_ERROR_BYTES, "--%s '%.200s': expected %s", option, value, expected);
    return false;
}

/* Appends a name to a comma-separated list. A name that does not fit is truncated. */
static void append_name(char text[], size_t size, const char *name) {
    const size_t used = strlen(text);
    (void)snprintf(text + used, size - used, "%s%s", used > 0 ? ", " : "", name);
}

static bool set_parameter(options_t *self, int parameter, const char *option, const char *argument, const char *number,
                          char error[]) {
    const parameter_description_t *description = &parameter_table[parameter];
    double value = 0.0;
    if (!option_number(number, (double)description->minimum, (double)description->maximum, &value) ||
        (description->integer && value != floor(value))) {
        char expected[160];
        (void)snprintf(expected, sizeof expected, "%s from %g to %g for %s",
                       description->integer ? "a whole number" : "a number", (double)description->minimum,
                       (double)description->maximum, description->name);
        return wrong(error, option, argument, expected);
    }
    self->operator.parameter_written[parameter] = true;
    self->operator.parameter_value[parameter] = (float)value;
    return true;
}

/* Sets the parameters of the paper's control law, except those set by --param. */
static void set_paper_law(operator_overrides_t *operator) {
    if (!operator->parameter_written[PARAMETER_PREDICTION]) {
        operator->parameter_written[PARAMETER_PREDICTION] = true;
        operator->parameter_value[PARAMETER_PREDICTION] = 0.0f;
    }
    for (int i = 0; i < PARAMETER_COUNT; i++) {
        const bool is_gain = i >= PARAMETER_GAIN_PER_S && i < PARAMETER_GAIN_PER_S + 8;
        const bool is_weight = i >= PARAMETER_WEIGHT && i < PARAMETER_WEIGHT + 8;
        if ((is_gain || is_weight || i == PARAMETER_ERROR_FRAME) && !operator->parameter_written[i]) {
            operator->parameter_written[i] = true;
            operator->parameter_value[i] = is_gain ? PAPER_GAIN_PER_S : is_weight ? 1.0f : (float)ERROR_FRAME_TORSO;
        }
    }
}

static bool parse_parameter(options_t *self, const char *argument, char error[]) {
    const char *equals = strchr(argument, '=');
    if (equals == NULL) {
        return wrong(error, "param", argument, "NAME=VALUE, for example task_blend_s=0.5");
    }
    const size_t name_bytes = (size_t)(equals - argument);
    char names[OPTIONS_ERROR_BYTES - 300] = "";
    for (int i = 0; i < PARAMETER_COUNT; i++) {
        const char *name = parameter_table[i].name;
        if (name == NULL) {
            continue; /* an unused parameter number */
        }
        if (strlen(name) == name_bytes && memcmp(name, argument, name_bytes) == 0) {
            return set_parameter(self, i, "param", argument, equals + 1, error);
        }
        append_name(names, sizeof names, name);
    }
    (void)snprintf(error, OPTIONS_ERROR_BYTES, "--param '%.100s': no parameter of this name; expected one of %s",
                   argument, names);
    return false;
}

static bool parse_mount_rotation(double rotation[4], const char *value, char error[]) {
    double q[4];
    if (option_numbers(value, ',', -1.0 - UNIT_TOLERANCE, 1.0 + UNIT_TOLERANCE, 4, q)) {
        const double norm = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        for (int i = 0; i < 4; i++) {
            rotation[i] = q[i] / norm;
        }
        if (fabs(norm - 1.0) <= UNIT_TOLERANCE) {
            return true;
        }
    }
    return wrong(error, "mount-rotation", value, "a quaternion w,x,y,z of norm 1 within 0.001");
}

static bool parse_gap(tracker_options_t *tracker, const char *value, char error[]) {
    double gap[2];
    if (!option_numbers(value, ':', 0.0, 86400.0, 2, gap)) {
        return wrong(error, "gap", value, "START:DURATION in seconds, each from 0 to 86400, for example 5:0.2");
    }
    tracker->gap_start_s = gap[0];
    tracker->gap_duration_s = gap[1];
    return true;
}

static bool parse_number(options_t *self, size_t row, const char *name, const char *value, char error[]) {
    double number = 0.0;
    if (!option_number(value, number_table[row].minimum, number_table[row].maximum, &number)) {
        return wrong(error, name, value, number_table[row].expected);
    }
    number *= number_table[row].unit;
    memcpy((char *)self + number_table[row].member, &number, sizeof number);
    return true;
}

static bool parse_value(options_t *self, int option, const char *name, const char *value, char error[]) {
    uint64_t number = 0;
    for (size_t row = 0; row < sizeof number_table / sizeof number_table[0]; row++) {
        if (number_table[row].option == option) {
            return parse_number(self, row, name, value, error);
        }
    }
    switch (option) {
    case OPTION_SCENARIO:
        self->scenario = value;
        return value[0] != '\0' || wrong(error, name, value, "a scenario's name or the path of its file");
    case OPTION_TRACKER:
        self->tracker_path = value;
        return value[0] != '\0' || wrong(error, name, value, "the path of a CSV file");
    case OPTION_TRACKER_SECOND:
        self->second_path = value;
        return value[0] != '\0' || wrong(error, name, value, "the path of a CSV file");
    case OPTION_PHYSICS_STEP:
        return (option_unsigned(value, 2000, &self->physics_step_us) &&
                (self->physics_step_us == 500 || self->physics_step_us == 1000 || self->physics_step_us == 2000)) ||
               wrong(error, name, value, "500, 1000 or 2000");
    case OPTION_AXES:
        self->axes = value;
        return value[0] != '\0' || wrong(error, name, value, "recorder axes for the torso's x, y, z, for example -yxz");
    case OPTION_OUT: self->out = value; return value[0] != '\0' || wrong(error, name, value, "the path of a folder");
    case OPTION_PROFILE:
        self->profile = strcmp(value, "classic") == 0 ? CAN_PROFILE_CLASSIC : CAN_PROFILE_FD;
        return self->profile == CAN_PROFILE_CLASSIC || strcmp(value, "fd") == 0 ||
               wrong(error, name, value, "fd or classic");
    case OPTION_HUB:
        self->hub = value;
        return hub_name_is_valid(value) ||
               wrong(error, name, value, "a bus name: 1 to 15 letters, digits, '_' and '-', for example vcan0");
    case OPTION_SEED:
        return option_unsigned(value, UINT64_MAX, &self->seed) ||
               wrong(error, name, value, "a whole number from 0 to 18446744073709551615");
    case OPTION_TRACKER_CLOCK:
        if (!option_unsigned(value, UINT32_MAX, &number)) {
            return wrong(error, name, value, "a whole number of us from 0 to 4294967295");
        }
        self->tracker.clock_start_us = (uint32_t)number;
        return true;
    case OPTION_MOUNT_TRANSLATION:
        return option_numbers(value, ',', -MOUNT_MAX_M, MOUNT_MAX_M, 3, self->tracker.mount_translation_m) ||
               wrong(error, name, value, "x,y,z in m, each from -1000 to 1000");
    case OPTION_MOUNT_ROTATION: return parse_mount_rotation(self->tracker.mount_rotation, value, error);
    case OPTION_GAP: return parse_gap(&self->tracker, value, error);
    case OPTION_DEFINE:
        self->operator.defines_task = true;
        return option_task(value, &self->operator.task) ||
               wrong(error, name, value,
                     "FORM:TX,TY,TZ:QW,QX,QY,QZ:IW,IX,IY,IZ:BLEND: FORM constant or mirrored, a translation with "
                     "each part from -8.388 to 8.388 m, two quaternions of norm 1 within 0.001, a blend time from 0 to "
                     "65.535 s");
    case OPTION_SCALE: return set_parameter(self, PARAMETER_MOTION_SCALE, name, value, value, error);
    default: /* OPTION_PARAM */ return parse_parameter(self, value, error);
    }
}

options_result_t options_parse(options_t *self, int argc, char *argv[], char error[OPTIONS_ERROR_BYTES]) {
    memset(self, 0, sizeof *self);
    self->scenario = "pour";
    self->physics_step_us = 1000;
    self->seed = 1;
    tracker_options_set_defaults(&self->tracker);
    self->tracker.rate_hz = 0.0; /* 0: the default of the bus profile */
    opterr = 0;                  /* this file prints its own messages */
    bool paper_law = false;
    int option, row = 0;
    while ((option = getopt_long(argc, argv, ":h", option_table, &row)) != -1) {
        switch (option) {
        case OPTION_HELP:
        case 'h': return OPTIONS_SHOW_HELP;
        case OPTION_LIST: return OPTIONS_SHOW_SCENARIOS;
        case OPTION_QUIET: self->quiet = true; break;
        case OPTION_REAL_TIME: self->real_time = true; break;
        case OPTION_PAPER_LAW: paper_law = true; break;
        case '?':
            if (optopt != 0 && optopt < OPTION_SCENARIO) { /* one letter, perhaps of several in one argument */
                (void)snprintf(error, OPTIONS_ERROR_BYTES, "'-%c': no such option; --help lists all options", optopt);
                return OPTIONS_WRONG;
            }
            (void)snprintf(error, OPTIONS_ERROR_BYTES, "'%.200s': %s; --help lists all options", argv[optind - 1],
                           optopt != 0 ? "this option takes no value" : "no such option, or an ambiguous abbreviation");
            return OPTIONS_WRONG;
        case ':':
            (void)snprintf(error, OPTIONS_ERROR_BYTES, "'%.200s': expected a value after it", argv[optind - 1]);
            return OPTIONS_WRONG;
        default:
            if (!parse_value(self, option, option_table[row].name, optarg, error)) {
                return OPTIONS_WRONG;
            }
        }
    }
    if (optind < argc) {
        (void)snprintf(error, OPTIONS_ERROR_BYTES, "'%.200s': expected options only; --help lists them", argv[optind]);
        return OPTIONS_WRONG;
    }
    if (self->axes != NULL && self->tracker_path == NULL && self->second_path == NULL) {
        (void)wrong(error, "axes", self->axes, "a recording with these axes: --tracker or --tracker-second FILE.csv");
        return OPTIONS_WRONG;
    }
    if (paper_law) {
        set_paper_law(&self->operator);
    }
    self->tracker.seed = self->seed;
    if (!(self->tracker.rate_hz > 0.0)) {
        self->tracker.rate_hz = 1e3 / (double)transport_period_ms(self->profile, FRAME_HAND_POSE);
    }
    return tracker_options_check(&self->tracker, error, OPTIONS_ERROR_BYTES) ? OPTIONS_RUN : OPTIONS_WRONG;
}
