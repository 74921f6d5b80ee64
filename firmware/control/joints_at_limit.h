/* Finds the joints at their position limits, and keeps inverse kinematics from driving them beyond these limits.
 *
 * Uses an active-set method. The equations for the joint velocities are solved, and each joint that is at a limit and
 * would move beyond it is locked, that is, its velocity is set to 0. The equations are then solved again for the
 * remaining joints, until no joint would move beyond a limit. The solution is thus the best one for the joints that can
 * move. */
#ifndef COMANIP_JOINTS_AT_LIMIT_H
#define COMANIP_JOINTS_AT_LIMIT_H

#include <stdbool.h>
#include <stdint.h>

#include "../arms/arm.h"

/* Bit masks: bit i is joint i. */
typedef struct {
    uint8_t lower, upper;
} joints_at_limit_t;

/* Finds the joints at their limits. A joint is at a limit if its distance from the limit is less than its margin.
 * margin_rad: joint_count values. */
joints_at_limit_t joints_at_limit_find(const arm_t *arm, const float margin_rad[], const float position_rad[]);

static inline bool joints_at_limit_any(joints_at_limit_t self) {
    return (self.lower | self.upper) != 0;
}

/* Returns the bit mask of the joints that are at a limit and would move beyond it. */
uint8_t joints_at_limit_going_beyond(joints_at_limit_t self, int joint_count, const float velocity_radps[]);

/* The caller's linear equations for the joint velocities, as two functions: one solves them for joint_count velocities,
 * and one locks joints (a bit mask) in all further solutions. */
typedef void joints_at_limit_solution_t(void *equations, float velocity_radps[]);
typedef void joints_at_limit_lock_t(void *equations, uint8_t joints);

/* Computes the solution in which no joint at a limit moves beyond it. velocity_radps: joint_count values. Solves the
 * equations once if no joint would move beyond a limit, and at most joint_count + 1 times. Inline, so that `solve` and
 * `lock` are not called through pointers. */
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
