/* Records the smallest clearances of the whole run, the force at each hand while that hand holds an object, and the
 * force in the gripper while the gripper holds an object. */
#ifndef COMANIP_SIM_CONTACT_MONITOR_H
#define COMANIP_SIM_CONTACT_MONITOR_H

#include <stdint.h>

#include "observer.h"
#include "physical_state.h"

typedef struct {
    double least_m; /* smallest clearance; infinite: never measured */
    int pair;       /* index for proximity_pair_name(); -1: none */
    double t_s;     /* time at which least_m was first measured */
} least_clearance_t;

typedef struct {
    uint64_t ticks; /* ticks in which an object was held */
    double square_N2;
    double peak_N;
} held_force_t;

typedef struct {
    least_clearance_t person, self;
    held_force_t hand[SCENARIO_MAX_PEOPLE];
    held_force_t gripper;
} contact_monitor_t;

void contact_monitor_init(contact_monitor_t *self);
void contact_monitor_sample(contact_monitor_t *self, const tick_record_t *tick, const physical_state_t *state);

/* Return the RMS and the peak force; NaN if nothing was ever held. */
double held_force_rms_N(const held_force_t *self);
double held_force_peak_N(const held_force_t *self);

#endif
