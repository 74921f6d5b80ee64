/* Parses the command line of comanip-sim. All options are checked here, before any file is written. */
#ifndef COMANIP_SIM_OPTIONS_H
#define COMANIP_SIM_OPTIONS_H

#include <stdbool.h>
#include <stdint.h>

#include "../../firmware/parameters/parameters.h"
#include "../../firmware/protocol/can_profile.h"
#include "../nodes/operator_script.h"
#include "../nodes/tracker_node.h"

#define OPTIONS_ERROR_BYTES 2048

typedef struct {
    const char *scenario;     /* name or path */
    const char *tracker_path; /* a recording for the tracked person; NULL: the scenario's built-in motion */
    const char *second_path;  /* a recording for the second person; NULL: the scenario's built-in motion */
    const char *axes;         /* axes of both recordings; NULL: chosen by the file name */
    const char *out;          /* NULL: out/SCENARIO */
    double duration_s;        /* 0: until all scripts have ended */
    uint64_t physics_step_us; /* 500, 1000 or 2000 */
    uint64_t seed;
    tracker_options_t tracker;
    operator_overrides_t operator;
    can_profile_t profile; /* profile of the bus */
    const char *hub;       /* name of the hub that publishes the bus; NULL: no hub */
    bool real_time;        /* run no faster than real time */
    bool quiet;
} options_t;

typedef enum {
    OPTIONS_RUN,
    OPTIONS_SHOW_HELP,
    OPTIONS_SHOW_SCENARIOS,
    OPTIONS_WRONG, /* `error` holds one line that names the option, its value and what was expected */
} options_result_t;

options_result_t options_parse(options_t *self, int argc, char *argv[], char error[OPTIONS_ERROR_BYTES]);

#endif
