/* Measures how well the end effector in ODE follows the target of Algorithm 1. There are two sets of statistics: over
 * all ticks in cooperation, and over the followable ticks, in which the arm was able to follow the target. Target and
 * end effector are compared at the same instant. */
#ifndef COMANIP_SIM_TRACKING_H
#define COMANIP_SIM_TRACKING_H

#include "observer.h"
#include "reach.h"

#define TRACKING_SETTLE_S 0.2   /* motion within this time after a joint leaves a limit does not count as followable */
#define TRACKING_LOOK_AHEAD 50  /* motion within this many ticks before a joint reaches a limit does not count either */
#define TRACKING_MEAN_TICKS 20  /* averaging time of a joint's commanded speed */
#define TRACKING_STOP_S 0.02    /* a joint that takes longer to stop cannot follow changes of the hand's motion */
#define TRACKING_REACH_TICKS 10 /* period of the reach search */

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
    uint64_t settled_ticks;                        /* ticks whose target appeared over TRACKING_SETTLE_S ago */
    int64_t no_target_ns;                          /* last time without a target */
    int64_t limited_ns;                            /* last time at which a joint was at a limit */
    double mean_velocity_radps[ROBOT_JOINTS];      /* commanded, averaged over about TRACKING_MEAN_TICKS */
    tracking_sums_t all;                           /* every tick in cooperation */
    tracking_sums_t followable;                    /* target in reach, no joint at a limit shortly before or after */
    tracking_error_t pending[TRACKING_LOOK_AHEAD]; /* ring buffer: followable unless a joint soon reaches a limit */
    size_t pending_first, pending_count;
} tracking_t;

void tracking_init(tracking_t *self);

/* Adds a finished tick. parameter: current values (PARAMETER_COUNT). */
void tracking_sample(tracking_t *self, const tick_record_t *tick, const float parameter[]);

/* Returns true if the arm could follow in this tick: the target is in reach and settled, and no joint has been at a
 * limit in the last TRACKING_SETTLE_S. Does not consider limits that a joint reaches later. */
bool tracking_is_followable(const tracking_t *self, const tick_record_t *tick);

double tracking_rms_position_mm(const tracking_sums_t *sums);
double tracking_rms_orientation_deg(const tracking_sums_t *sums);

double tracking_distance_mm(const tick_record_t *tick);

#endif
