/* How well ODE's hand follows Algorithm 1's target: statistics over the ticks in cooperation, hand and target of the
 * same instant, and which part of it the arm could have followed at all. */
#ifndef COMANIP_SIM_TRACKING_H
#define COMANIP_SIM_TRACKING_H

#include "observer.h"
#include "reach.h"

#define TRACKING_SETTLE_S 0.2   /* so long after a limit, and ... */
#define TRACKING_LOOK_AHEAD 50  /* ... so many ticks before one, the arm could not follow */
#define TRACKING_MEAN_TICKS 20  /* over which a joint's commanded speed is averaged */
#define TRACKING_STOP_S 0.02    /* a joint that needs longer to stop cannot follow a hand's changes */
#define TRACKING_REACH_TICKS 10 /* reach is searched once in so many ticks */

typedef struct {
    double position_mm, orientation_deg;
} tracking_error_t;

typedef struct {
    uint64_t ticks;
    double square_position_mm2; /* sums of squares */
    double square_orientation_deg2;
    double max_position_mm;
    double max_orientation_deg;
} tracking_sums_t;

typedef struct {
    reach_t reach;
    uint64_t ticks_to_next_search;
    bool in_reach;
    uint64_t out_of_reach_ticks;
    uint64_t cooperating_ticks;
    uint64_t
        settled_ticks; /* of these, later than TRACKING_SETTLE_S after the start and after each return of the target */
    int64_t no_target_ns;                          /* when there was last none */
    int64_t limited_ns;                            /* when a joint was last at one of its limits */
    double mean_velocity_radps[ROBOT_JOINTS];      /* commanded, over about TRACKING_MEAN_TICKS */
    tracking_sums_t all;                           /* every tick in cooperation */
    tracking_sums_t followable;                    /* in reach, and no joint at a limit shortly before or after */
    tracking_error_t pending[TRACKING_LOOK_AHEAD]; /* ring: followable, unless a limit comes */
    size_t pending_first, pending_count;
} tracking_t;

void tracking_init(tracking_t *self);

/* One finished tick. parameter: in force (PARAMETER_COUNT values). */
void tracking_sample(tracking_t *self, const tick_record_t *tick, const float parameter[]);

/* The arm could follow in the last tick, as far as is known by then: in reach, settled, and no joint at a limit of
 * late. */
bool tracking_is_followable(const tracking_t *self, const tick_record_t *tick);

double tracking_rms_position_mm(const tracking_sums_t *sums);
double tracking_rms_orientation_deg(const tracking_sums_t *sums);

double tracking_distance_mm(const tick_record_t *tick);

#endif
