/* Joints at their position limits: which joints are, and how inverse kinematics drives none of them beyond.
 *
 * An active-set method. The equations for the joint velocities are solved; the joints that would go beyond a limit they
 * are at are locked, that is, their velocity is 0; and the equations are solved again for the other joints, until no
 * joint would go beyond. The other joints then do what they can, instead of counting on joints that cannot move. */
#ifndef COMANIP_JOINTS_AT_LIMIT_H
#define COMANIP_JOINTS_AT_LIMIT_H

#include <stdbool.h>
#include <stdint.h>

#include "../arms/arm.h"

/* Bit masks: bit i is joint i. */
typedef struct {
    uint8_t lower, upper;
} joints_at_limit_t;

/* margin_rad: joint_count values. A joint is at a limit when it is nearer to it than its margin. */
joints_at_limit_t joints_at_limit_find(const arm_t *arm, const float margin_rad[], const float position_rad[]);

static inline bool joints_at_limit_any(joints_at_limit_t self) {
    return (self.lower | self.upper) != 0;
}

/* Linear equations for the velocities of an arm's joints, as the caller keeps them. */
typedef struct {
    void *equations;
    void (*solve)(void *equations, float velocity_radps[]); /* writes joint_count values */
    void (*lock)(void *equations, uint8_t joints); /* bit mask: from the next solve() on, their velocity is 0 */
} lockable_equations_t;

/* velocity_radps: joint_count values, the solution in which no joint goes beyond a limit it is at. Solves the equations
 * once if none would, and at most joint_count + 1 times. */
void joints_at_limit_solve(joints_at_limit_t self, int joint_count, const lockable_equations_t *system,
                           float velocity_radps[]);

#endif
