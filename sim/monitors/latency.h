/* How late the robot's hand is behind the person's, and where the time goes. Definitions: docs/scenarios.md. */
#ifndef COMANIP_SIM_LATENCY_H
#define COMANIP_SIM_LATENCY_H

#include "bus_delays.h"
#include "delay_fit.h"
#include "observer.h"

#define LATENCY_MOVES_MPS 0.02 /* mean over LATENCY_MEAN_TICKS: tremor leads nowhere and is no measure of a delay */
#define LATENCY_MEAN_TICKS 200
#define LATENCY_NEEDED_S 1.0
#define LATENCY_PAST_TICKS                                                                                             \
    512 /* power of two, and above DELAY_LAST_TICKS - DELAY_FIRST_TICKS + LATENCY_MEAN_TICKS / 2 */
#define LATENCY_SAMPLE_TICKS 4

/* One tick as it was. */
typedef struct {
    double hand_m[3];
    delay_hand_t hand; /* the same as Algorithm 1 takes it */
    bool counts;       /* the target's followers are known, and the arm could follow */
    double follower_m[DELAY_FOLLOWERS][3];
} latency_tick_t;

typedef struct {
    latency_tick_t past[LATENCY_PAST_TICKS]; /* ring, by the number of the tick */
    uint64_t ticks;
    uint64_t stretch_from; /* the tick in which the cooperation last changed */
    int64_t settled_ns;
    int64_t target_ns; /* of the last target seen */
    double forward_m;  /* where the hand was then: mirroring counts from it */
    uint64_t sampled;  /* tick of the last sample */
    uint64_t samples;
    delay_fit_t fit;
} latency_t;

/* Means [ms]; NaN: not known. tracker + bus + estimate + law + command + drive = end_to_end. */
typedef struct {
    double tracker, bus, estimate, law, command, drive, end_to_end;
    double moved_s; /* what end_to_end was measured over; below LATENCY_NEEDED_S it is not known */
} latency_ms_t;

void latency_init(latency_t *self);

/* One finished tick. hand: ODE's, of the tracked person, at its begin; follows: how the robot goes along with it, per
 * axis; settled_ns: the observer's; followable: the arm could follow. */
void latency_sample(latency_t *self, const tick_record_t *tick, const rigid_pose_t *hand, const double follows[3],
                    int64_t settled_ns, bool followable);

/* The run is over. */
latency_ms_t latency_end(latency_t *self, const bus_delays_t *bus, double drive_s);

#endif
