/* Measures the time by which the end effector lags behind the person's hand, and the components of this latency, which
 * docs/scenarios.md defines. */
#ifndef COMANIP_SIM_LATENCY_H
#define COMANIP_SIM_LATENCY_H

#include "bus_delays.h"
#include "delay_fit.h"
#include "observer.h"

#define LATENCY_MOVES_MPS 0.02 /* mean speed over LATENCY_MEAN_TICKS that counts as motion; tremor averages out */
#define LATENCY_MEAN_TICKS 200
#define LATENCY_NEEDED_S 1.0
#define LATENCY_PAST_TICKS 512 /* more than DELAY_LAST_TICKS - DELAY_FIRST_TICKS, the age of the oldest pose needed */
#define LATENCY_SAMPLE_TICKS 4

/* The record of one tick. */
typedef struct {
    double hand_m[3];
    delay_hand_t hand; /* the hand's contribution to the target */
    bool counts;       /* follower_m is known, and the arm could follow */
    double follower_m[DELAY_FOLLOWERS][3];
} latency_tick_t;

typedef struct {
    latency_tick_t past[LATENCY_PAST_TICKS]; /* ring buffer, indexed by tick number */
    uint64_t ticks;
    uint64_t stretch_from; /* last tick without cooperation, with a new command, or during a blend of tasks */
    int64_t settled_ns;
    int64_t target_ns; /* time of the last target received */
    double forward_m;  /* x position of the hand at stretch_from, the origin of mirroring */
    uint64_t sampled;  /* tick of the last sample */
    uint64_t samples;
    delay_fit_t fit;
} latency_t;

/* Mean latencies [ms]; NaN: not measured. tracker + bus + estimate + law + command + drive = end_to_end. */
typedef struct {
    double tracker, bus, estimate, law, command, drive, end_to_end;
    double moved_s; /* duration of the measured motion; if below LATENCY_NEEDED_S, end_to_end is NaN */
} latency_ms_t;

void latency_init(latency_t *self);

/* Adds a finished tick. hand: the tracked person's hand in ODE at the start of the tick. gain: displacement of the end
 * effector per displacement of the hand, for each axis. settled_ns: as in observer_t. followable: true if the arm could
 * follow the target (tracking_is_followable()). */
void latency_sample(latency_t *self, const tick_record_t *tick, const rigid_pose_t *hand, const double gain[3],
                    int64_t settled_ns, bool followable);

/* Returns the results. Must be called at the end of the run. */
latency_ms_t latency_end(latency_t *self, const bus_delays_t *bus, double drive_s);

#endif
