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

/* Bit mask of the joints that would go beyond a limit they are at. */
uint8_t joints_at_limit_going_beyond(joints_at_limit_t self, int joint_count, const float velocity_radps[]);

/* Linear equations for the joint velocities, as the caller keeps them: their solution, joint_count values; and how to
 * lock joints, a bit mask, for all further solutions. */
typedef void joints_at_limit_solution_t(void *equations, float velocity_radps[]);
typedef void joints_at_limit_lock_t(void *equations, uint8_t joints);

/* velocity_radps: joint_count values, the solution in which no joint goes beyond a limit it is at. Solves the equations
 * once if none would, and at most joint_count + 1 times. In line, so that nothing is called through a pointer. */
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
