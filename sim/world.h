/* The simulated world: arm, drives, tracker and operator on one bus, in virtual time and lockstep, watched by monitors
 * that see the bus and ODE and nothing of the firmware. The firmware joins through the host port (hal/host). */
#ifndef COMANIP_SIM_WORLD_H
#define COMANIP_SIM_WORLD_H

#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bus/bus.h"
#include "bus/candump_log.h"
#include "monitors/observer.h"
#include "monitors/scenario_monitor.h"
#include "monitors/tracking.h"
#include "nodes/drive_node.h"
#include "nodes/operator_node.h"
#include "nodes/tracker_node.h"
#include "options/options.h"
#include "output/trace_csv.h"
#include "robot/arm_plant.h"

#define WORLD_TICK_NS 1000000
#define WORLD_TEXT_BYTES 500

typedef struct world world_t;

struct world {
    const options_t *options;
    int64_t end_ns;
    int64_t now_ns;
    uint64_t ticks;
    bus_t *bus;
    arm_plant_t *plant;
    drive_node_t *drives;
    tracker_node_t *tracker;
    operator_node_t *operator;
    observer_t observer;
    tracking_t tracking;
    scenario_monitor_t scenario_monitor;
    candump_log_t *log;
    trace_csv_t trace;
    const volatile sig_atomic_t *interrupted; /* set from outside to end the run */
    uint64_t firmware_overflows; /* frames lost in the firmware's receive queue: counted by the host port */
    void (*on_tick)(const world_t *world); /* NULL, or called after each tick: it watches and changes nothing */
    char failure[WORLD_TEXT_BYTES]; /* why the run ended early; "" */
};

/* How long the run of these options will be. */
double world_duration_s(const options_t *options, const hand_motion_t *motion);

/* options and motion must outlive the world. The files at log_path and trace_path are created. On failure false, and one
 * line in `error`. */
bool world_init(world_t *self, const options_t *options, const hand_motion_t *motion, const char *log_path,
                const char *trace_path, const volatile sig_atomic_t *interrupted, char error[], size_t error_size);

/* One tick of 1 ms. False when the run is over. */
bool world_advance(world_t *self);

/* The scenario's own motion and task: then what must come out is known beforehand. */
bool world_is_scripted(const world_t *self);

/* Ends the run with a reason; the first one counts. */
void world_fail(world_t *self, const char *reason);

/* Closes the files. On failure false, and one line in `error`. */
bool world_close_files(world_t *self, const char *trace_path, char error[], size_t error_size);

void world_free(world_t *self);

#endif
