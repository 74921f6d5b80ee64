/* By how much something follows the person's hand late: the delay at which least squares leaves the least.
 *
 * Between two commands of the operator, Algorithm 1 makes of the hand's position h and rotation R the target s h + R k
 * + b (mirrored: less twice the way forward along the target's z axis), with constants k and b that come from the start
 * poses and the task. So for each delay d of a grid, follower(t) - s h(t - d) is fitted by R(t - d) k + b, and what is
 * left, over all stretches between commands, is least at the delay that was. The constants need not be known, nor is
 * anything taken from the firmware's own arithmetic. */
#ifndef COMANIP_SIM_DELAY_FIT_H
#define COMANIP_SIM_DELAY_FIT_H

#include <stdbool.h>
#include <stdint.h>

#define DELAY_STEP_TICKS 2
#define DELAY_FIRST_TICKS (-20) /* a follower may be early */
#define DELAY_COUNT 161         /* up to 300 ms */
#define DELAY_LAST_TICKS (DELAY_FIRST_TICKS + (DELAY_COUNT - 1) * DELAY_STEP_TICKS)

typedef enum { DELAY_OF_TARGET, DELAY_OF_ROBOT, DELAY_FOLLOWERS } delay_follower_t;

/* The hand's part of the target at one instant. */
typedef struct {
    double way_m[3];   /* s h, or what is mirrored of it */
    double turn[3][3]; /* R */
} delay_hand_t;

typedef struct {
    double turn[3][3]; /* sums over the stretch: of R, and of what is to be fitted by it, turned by R^T, and squared */
    struct {
        double rest_m[3], turned_m[3], square_m2;
    } follower[DELAY_FOLLOWERS];
} delay_sums_t;

typedef struct {
    uint64_t samples; /* of the stretch */
    delay_sums_t sums[DELAY_COUNT];
    double left_m2[DELAY_COUNT][DELAY_FOLLOWERS]; /* of all stretches before */
} delay_fit_t;

/* follower_m: where each is at t; hand[n]: the hand at t less DELAY_FIRST_TICKS + n DELAY_STEP_TICKS. */
void delay_fit_add(delay_fit_t *self, double follower_m[DELAY_FOLLOWERS][3], const delay_hand_t *hand[DELAY_COUNT]);

/* The operator has commanded something: the constants are others from here on. */
void delay_fit_end_stretch(delay_fit_t *self);

/* [ms], after delay_fit_end_stretch(); NaN if it is at an end of the grid, or nothing was added. */
double delay_fit_ms(const delay_fit_t *self, delay_follower_t follower);

#endif
