/* Measures, tick by tick, what a scenario's own checks ask for: each in its window (check_window.h), from the tick's
 * record (bus and ODE's hand), the scene's state and the events. What each is stands at measure_t in scenario.h; where
 * that leaves a choice:
 *
 * - Displacement, way, turn, turns and water_poured count from the first tick of the window. Their value is that of its
 *   last tick, as for held and water_caught. water_caught is a share of all that left the cup
 *   and did not fall back into it.
 * - A hand moves, for flow_while_moving, if it came further than 5 mm/s in the last 0.2 s: tremor alone is as fast, but
 *   leads nowhere.
 * - drops counts two things: each OBJECT.dropped (20 ms in nobody's hand: scene.h), and each robot.lost or PERSON.lost
 * of who held the object then. An object that slips out and falls counts twice.
 * - carried_for adds up all ticks in which robot and person hold the object.
 * - Force is the magnitude of the vector, in ticks in which the person holds the object.
 * - A window of settled_position or following_rms with a target in less than half of its ticks is not measured. */
#ifndef COMANIP_SIM_SCENARIO_MONITOR_H
#define COMANIP_SIM_SCENARIO_MONITOR_H

#include "../scenario/scenario.h"
#include "measurement.h"
#include "observer.h"
#include "physical_state.h"

#define SCENARIO_MONITOR_PAST_TICKS 200 /* over which a hand's speed is averaged */
#define SCENARIO_MONITOR_MOVING_MPS 0.005

typedef struct {
    const scenario_t *scenario;
    measurement_t measurement[SCENARIO_MAX_CHECKS];
    bool has_start;
    rigid_pose_t start; /* ODE's hand at the first tick in cooperation */
    double past_m[SCENARIO_MONITOR_PAST_TICKS][SCENARIO_MAX_PEOPLE][3]; /* ring of the people's hands */
    uint64_t ticks;
    int left_cup_before; /* a tick ago, as the next two */
    bool held_before[SCENARIO_MAX_PEOPLE + 1][SCENARIO_MAX_OBJECTS];
    int lost_before[SCENARIO_MAX_PEOPLE + 1];
    int lost_event[SCENARIO_MAX_PEOPLE + 1]; /* of each holder; EVENT_NONE */
    int dropped_before[SCENARIO_MAX_OBJECTS];
    int dropped_event[SCENARIO_MAX_OBJECTS]; /* of each object; EVENT_NONE */
} scenario_monitor_t;

/* The scenario must outlive the monitor. */
void scenario_monitor_init(scenario_monitor_t *self, const scenario_t *scenario);

/* One finished tick: record and state of its instant, events as they stand at its end. */
void scenario_monitor_sample(scenario_monitor_t *self, const tick_record_t *tick, const physical_state_t *state,
                             const events_t *events, double motion_scale);

#endif
