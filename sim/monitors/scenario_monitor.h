/* Takes the measurements for the checks of a scenario, in every tick of each check's window (check_window.h). The
 * inputs are the record of the tick (bus, and end effector in ODE), the state of the scene, and the events. measure_t
 * in scenario.h defines the measures. Details:
 * - Displacement, way, turn, turns and water_poured are relative to the first tick of the window. They take the
 *   value of the last tick, as do held and water_caught. water_caught is a share of all particles that left the cup and
 *   did not fall back into it.
 * - For flow_while_moving, a hand counts as moving if its mean velocity over the last 0.2 s exceeds 5 mm/s. Tremor can
 *   reach this speed, but its mean over 0.2 s is small.
 * - drops counts each OBJECT.dropped (held by nobody for 20 ms, see scene.h), and each robot.lost or PERSON.lost that
 *   the holder of the object raises. An object that slips out and then falls counts twice.
 * - carried_for is the total time in which both robot and person hold the object.
 * - Forces are magnitudes, measured in ticks in which the person holds the object.
 * - settled_position and following_rms are not measured if fewer than half of the window's ticks have a target. */
#ifndef COMANIP_SIM_SCENARIO_MONITOR_H
#define COMANIP_SIM_SCENARIO_MONITOR_H

#include "../scenario/scenario.h"
#include "measurement.h"
#include "observer.h"
#include "physical_state.h"

#define SCENARIO_MONITOR_PAST_TICKS 200 /* averaging time of a hand's speed */
#define SCENARIO_MONITOR_MOVING_MPS 0.005

typedef struct {
    const scenario_t *scenario;
    measurement_t measurement[SCENARIO_MAX_CHECKS];
    bool has_start;
    rigid_pose_t start; /* end effector at the first tick in cooperation */
    double past_m[SCENARIO_MONITOR_PAST_TICKS][SCENARIO_MAX_PEOPLE][3]; /* ring buffer of hand positions */
    uint64_t ticks;
    int left_cup_before; /* value in the previous tick, like all *_before members */
    bool held_before[SCENARIO_MAX_PEOPLE + 1][SCENARIO_MAX_OBJECTS];
    int lost_before[SCENARIO_MAX_PEOPLE + 1];
    int lost_event[SCENARIO_MAX_PEOPLE + 1]; /* index of each holder's `lost` event, or EVENT_NONE */
    int dropped_before[SCENARIO_MAX_OBJECTS];
    int dropped_event[SCENARIO_MAX_OBJECTS]; /* index of each object's `dropped` event, or EVENT_NONE */
} scenario_monitor_t;

/* The scenario must outlive the monitor. */
void scenario_monitor_init(scenario_monitor_t *self, const scenario_t *scenario);

/* Adds a finished tick. tick, state: at the start of the tick. events: at the end. */
void scenario_monitor_sample(scenario_monitor_t *self, const tick_record_t *tick, const physical_state_t *state,
                             const events_t *events, double motion_scale);

#endif
