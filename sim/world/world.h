/* The simulated world: a physical scene with robot and people, and on one bus its drives, gripper, tracker, proximity
 * sensor and operator, in virtual time and lockstep, watched by monitors that see the bus and the physics and nothing
 * of the firmware. The firmware joins as a node of the bus (sim/port). */
#ifndef COMANIP_SIM_WORLD_H
#define COMANIP_SIM_WORLD_H

#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "../bus/bus.h"
#include "../bus/live_bus.h"
#include "../hand/hand_history.h"
#include "../monitors/contact_monitor.h"
#include "../monitors/largest_scale.h"
#include "../monitors/latency.h"
#include "../monitors/observer.h"
#include "../monitors/physical_state.h"
#include "../monitors/rest_monitor.h"
#include "../monitors/scenario_monitor.h"
#include "../monitors/tracking.h"
#include "../nodes/drive_node.h"
#include "../nodes/gripper_node.h"
#include "../nodes/operator_node.h"
#include "../nodes/proximity_node.h"
#include "../nodes/tracker_node.h"
#include "../options/options.h"
#include "../people/person_program.h"
#include "../proximity/proximity.h"
#include "../scenario/scenario.h"
#include "../scene/scene.h"

#define WORLD_TICK_NS 1000000
#define WORLD_TEXT_BYTES 900 /* an operator's failure, and what is said of the tracker beside it */

typedef struct world world_t;

struct world {
    const options_t *options;
    const scenario_t *scenario; /* as the seed varied it */
    events_t events;
    int64_t now_ns;
    int64_t end_ns;     /* an upper bound until everybody is done */
    double stop_s;      /* when the operator's stop was due; negative: not yet */
    bool has_fixed_end; /* --duration: it goes on to its end though everybody is done */
    bool is_shortened;  /* and ends before the scenario's time is over: what is not done by then is nobody's failure */
    bool has_recording;
    uint64_t ticks;

    scene_t *scene;
    person_program_t *program[SCENARIO_MAX_PEOPLE];
    hand_history_t *hand_history; /* of the tracked person */
    proximity_t *proximity;
    measured_clearance_t clearance;
    physical_state_t state; /* of the scene, at now_ns */

    bus_t *bus;
    drive_node_t *drives;
    gripper_node_t *gripper;
    tracker_node_t *tracker;
    proximity_node_t *proximity_sensor;
    operator_node_t *operator;

    observer_t observer;
    tracking_t tracking;
    largest_scale_t largest_scale; /* of the recording on the command line */
    rest_monitor_t rest;
    latency_t latency;
    latency_ms_t latency_ms; /* once the run is over */
    scenario_monitor_t scenario_monitor;
    contact_monitor_t contact_monitor;

    const volatile sig_atomic_t *interrupted; /* set from outside to end the run */
    uint64_t firmware_overflows;              /* frames lost in the firmware's receive queue (sim/port) */
    /* NULL, or called after each tick: it watches and changes nothing */
    void (*on_tick)(void *context, const world_t *world);
    void *on_tick_context;
    const live_bus_timing_t *timing; /* NULL, or how the run kept up with real time */
    char failure[WORLD_TEXT_BYTES];  /* why the run ended early; "" */
};

/* options and scenario must outlive the world, which owns the bus from here on, even if this fails. Reads the
 * recordings and writes nothing. On failure false, and one line in `error`. */
bool world_init(world_t *self, const options_t *options, const scenario_t *scenario, bus_t *bus,
                const volatile sig_atomic_t *interrupted, char error[], size_t error_size);

/* One tick of 1 ms. False when the run is over. */
bool world_advance(world_t *self);

/* The scenario's own motion and task: then what must come out is known beforehand. */
bool world_is_scripted(const world_t *self);

/* Ends the run with a reason; the first one counts. */
void world_fail(world_t *self, const char *reason);

void world_free(world_t *self);

#endif
