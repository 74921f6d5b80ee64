/* Estimates the times by which the target and the end effector lag behind the person's hand. Each estimate is the delay
 * with the smallest least-squares residual.
 *
 * Between two commands of the operator, Algorithm 1 maps the hand's position h and rotation R to the target s h + R k +
 * b. Here s is the motion scale, and the constants k and b follow from the start poses and the task. If the task
 * mirrors, twice the hand's forward displacement times s is subtracted along the target's z axis. A follower is the
 * target or the end effector. For each delay d of a grid, k and b are chosen so that R(t - d) k + b fits follower(t) -
 * s h(t - d) best. The residual, summed over all intervals between commands, is smallest at the true delay. The
 * constants need not be known, and the fit does not depend on the firmware's arithmetic. */
#ifndef COMANIP_SIM_DELAY_FIT_H
#define COMANIP_SIM_DELAY_FIT_H

#include <stdbool.h>
#include <stdint.h>

#define DELAY_STEP_TICKS 2
#define DELAY_FIRST_TICKS (-20) /* negative, because a follower may be ahead of the hand */
#define DELAY_COUNT 161         /* delays of up to 300 ms */
#define DELAY_LAST_TICKS (DELAY_FIRST_TICKS + (DELAY_COUNT - 1) * DELAY_STEP_TICKS)

typedef enum { DELAY_OF_TARGET, DELAY_OF_ROBOT, DELAY_FOLLOWERS } delay_follower_t;

/* The hand's contribution to the target at one instant. */
typedef struct {
    double scaled_hand_m[3]; /* s h, mirrored if the task mirrors */
    double turn[3][3];       /* R */
} delay_hand_t;

/* Sums over the current interval. */
typedef struct {
    double turn[3][3]; /* R */
    struct {
        double fitted_m[3];  /* follower - s h */
        double rotated_m[3]; /* R^T (follower - s h) */
        double square_m2;    /* |follower - s h|^2 */
    } follower[DELAY_FOLLOWERS];
} delay_sums_t;

typedef struct {
    uint64_t samples; /* samples in the current interval */
    delay_sums_t sums[DELAY_COUNT];
    double residual_m2[DELAY_COUNT][DELAY_FOLLOWERS]; /* residuals of all earlier intervals */
} delay_fit_t;

/* Adds a sample of tick t. follower_m: positions of the followers in tick t. hand[n]: the hand in tick
 * t - (DELAY_FIRST_TICKS + n DELAY_STEP_TICKS). */
void delay_fit_add(delay_fit_t *self, double follower_m[DELAY_FOLLOWERS][3], const delay_hand_t *hand[DELAY_COUNT]);

/* Ends the current interval. Call it when a command of the operator changes the constants, and at the end of the
 * run. */
void delay_fit_end_stretch(delay_fit_t *self);

/* Returns the delay [ms]; NaN if the best delay is the first or the last of the grid, or if there are no samples. Call
 * delay_fit_end_stretch() first. */
double delay_fit_ms(const delay_fit_t *self, delay_follower_t follower);

#endif
