/* Finds the joints at their position limits, and keeps inverse kinematics from driving them beyond.
 *
 * An active-set method: the equations for the joint velocities are solved. Joints that would go beyond a limit that
 * they are at are locked, that is, their velocity is set to 0. The equations are solved again for the other joints,
 * until no joint would go beyond a limit. The solution thus makes the best of the joints that can move. */
#ifndef COMANIP_JOINTS_AT_LIMIT_H
#define COMANIP_JOINTS_AT_LIMIT_H

#include <stdbool.h>
#include <stdint.h>

#include "../arms/arm.h"

/* Bit masks: bit i is joint i. */
typedef struct {
    uint8_t lower, upper;
} joints_at_limit_t;

/* A joint is at a limit if it is nearer to the limit than its margin. margin_rad: joint_count values. */
joints_at_limit_t joints_at_limit_find(const arm_t *arm, const float margin_rad[], const float position_rad[]);

static inline bool joints_at_limit_any(joints_at_limit_t self) {
    return (self.lower | self.upper) != 0;
}

/* Bit mask of the joints that would go beyond a limit that they are at. */
uint8_t joints_at_limit_going_beyond(joints_at_limit_t self, int joint_count, const float velocity_radps[]);

/* The caller's linear equations for the joint velocities: a function that solves them (joint_count values), and one
 * that locks joints (a bit mask) for all further solutions. */
typedef void joints_at_limit_solution_t(void *equations, float velocity_radps[]);
typedef void joints_at_limit_lock_t(void *equations, uint8_t joints);

/* velocity_radps: joint_count values, the solution in which no joint goes beyond a limit that it is at. Solves the
 * equations once if no joint would, and at most joint_count + 1 times. Inline, so that no function is called through a
 * pointer. */
static inline void joints_at_limit_solve(joints_at_limit_t self, int joint_count, void *equations,
                                         joints_at_limit_solution_t *solve, joints_at_limit_lock_t *lock,
                                         float velocity_radps[]) {
    uint8_t locked = 0;
    for (;;) {
        solve(equations, velocity_radps);
        const uint8_t beyond = joints_at_limit_going_beyond(self, joint_count, velocity_radps);
        const uint8_t newly_locked = (uint8_t)(beyond & ~locked);
        if (newly_locked == 0u) {
            return;
        }
        lock(equations, newly_locked);
        locked |= newly_locked;
    }
}

#endif
