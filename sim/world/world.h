/* The simulated world consists of a physical scene with robot and people, and of a bus with the drives, the gripper,
 * the tracker, the proximity sensor and the operator. The firmware is another node on the bus. On the simulated bus
 * (bus.c), the world runs in virtual time and in lockstep with the firmware (sim/port); on a real bus (live_bus.c), it
 * runs in real time. Monitors observe the bus and the physics, but not the firmware itself. */
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
#define WORLD_TEXT_BYTES 900 /* enough for the message that the operator failed and the remark about the tracker */

typedef struct world world_t;

struct world {
    const options_t *options;
    const scenario_t *scenario; /* already varied by the seed */
    events_t events;
    int64_t now_ns;
    int64_t end_ns;     /* latest end of the run; without has_fixed_end, the run ends once all scripts are done */
    double stop_s;      /* time at which the operator was told to stop the arm; negative until then */
    bool has_fixed_end; /* --duration: the run continues until end_ns, even if all scripts are done */
    bool is_shortened;  /* the run ends before the scenario's duration_s; unfinished scripts then do not fail it */
    bool has_recording;
    uint64_t ticks;

    scene_t *scene;
    person_program_t *program[SCENARIO_MAX_PEOPLE];
    hand_history_t *hand_history; /* poses of the tracked person's hand */
    proximity_t *proximity;
    measured_clearance_t clearance;
    physical_state_t state; /* state of the scene at now_ns */

    bus_t *bus;
    drive_node_t *drives;
    gripper_node_t *gripper;
    tracker_node_t *tracker;
    proximity_node_t *proximity_sensor;
    operator_node_t *operator;

    observer_t observer;
    tracking_t tracking;
    largest_scale_t largest_scale; /* for the recording on the command line */
    rest_monitor_t rest;
    latency_t latency;
    latency_ms_t latency_ms; /* valid after the run */
    scenario_monitor_t scenario_monitor;
    contact_monitor_t contact_monitor;

    const volatile sig_atomic_t *interrupted; /* set from outside to end the run */
    uint64_t firmware_overflows;              /* frames lost in the firmware's receive queue (sim/port) */
    /* Called after each tick, unless NULL. It must not change the world. */
    void (*on_tick)(void *context, const world_t *world);
    void *on_tick_context;
    const live_bus_timing_t *timing; /* how well the run kept up with real time; NULL in virtual time */
    char failure[WORLD_TEXT_BYTES];  /* why the run failed; "" if it did not */
};

/* options and scenario must outlive the world. The world takes ownership of the bus, even on failure. Reads the
 * recordings, but does not write any files. Returns false on failure, with one line in `error`. */
bool world_init(world_t *self, const options_t *options, const scenario_t *scenario, bus_t *bus,
                const volatile sig_atomic_t *interrupted, char error[], size_t error_size);

/* Advances by one tick of 1 ms. Returns false when the run is over. */
bool world_advance(world_t *self);

/* Returns true if motion and task are the scenario's own, rather than a recording or a task from --define. */
bool world_is_scripted(const world_t *self);

/* Ends the run as failed for this reason. Only the first reason is kept. */
void world_fail(world_t *self, const char *reason);

void world_free(world_t *self);

#endif
