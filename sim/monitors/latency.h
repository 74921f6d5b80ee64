/* Measures the latency of the end effector behind the person's hand, and its components. Definitions:
 * docs/scenarios.md. */
#ifndef COMANIP_SIM_LATENCY_H
#define COMANIP_SIM_LATENCY_H

#include "bus_delays.h"
#include "delay_fit.h"
#include "observer.h"

#define LATENCY_MOVES_MPS 0.02 /* mean over LATENCY_MEAN_TICKS, so that tremor does not count as motion */
#define LATENCY_MEAN_TICKS 200
#define LATENCY_NEEDED_S 1.0
#define LATENCY_PAST_TICKS 512 /* a power of two above DELAY_LAST_TICKS - DELAY_FIRST_TICKS + LATENCY_MEAN_TICKS / 2 */
#define LATENCY_SAMPLE_TICKS 4

/* The record of one tick. */
typedef struct {
    double hand_m[3];
    delay_hand_t hand; /* the hand's contribution to the target */
    bool counts;       /* follower_m is known, and the arm could follow */
    double follower_m[DELAY_FOLLOWERS][3];
} latency_tick_t;

typedef struct {
    latency_tick_t past[LATENCY_PAST_TICKS]; /* ring buffer, by tick number */
    uint64_t ticks;
    uint64_t stretch_from; /* the tick of the last change of the cooperation */
    int64_t settled_ns;
    int64_t target_ns; /* of the last target received */
    double forward_m;  /* position of the hand at stretch_from, the origin of mirroring */
    uint64_t sampled;  /* tick of the last sample */
    uint64_t samples;
    delay_fit_t fit;
} latency_t;

/* Means [ms]; NaN: not measured. tracker + bus + estimate + law + command + drive = end_to_end. */
typedef struct {
    double tracker, bus, estimate, law, command, drive, end_to_end;
    double moved_s; /* duration over which end_to_end was measured; below LATENCY_NEEDED_S it is NaN */
} latency_ms_t;

void latency_init(latency_t *self);

/* Adds a finished tick. hand: the tracked person's hand in ODE at the begin of the tick; gain: displacement of the end
 * effector per displacement of the hand, per axis; settled_ns: from the observer; followable: the arm could follow. */
void latency_sample(latency_t *self, const tick_record_t *tick, const rigid_pose_t *hand, const double gain[3],
                    int64_t settled_ns, bool followable);

/* Called at the end of the run; returns the results. */
latency_ms_t latency_end(latency_t *self, const bus_delays_t *bus, double drive_s);

#endif
