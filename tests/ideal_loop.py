"""Simulates an ideal control loop: without bus and encoder, with dqrobotics' kinematics in double precision, and with
drives that follow each command without delay. It is written from the paper and from the description of the limits in
the C headers, not from the C sources."""

from __future__ import annotations

import numpy as np
import oracle
from dqrobotics import DQ, vec8

TICK_S = 1e-3
GAIN, WEIGHT, DAMPING = 35.0, np.r_[[0.01] * 4, [100.0] * 4], 1e-2
IDENTITY = np.array([1.0, 0, 0, 0, 0, 0, 0, 0])
VELOCITY_MAX = 4.76
JOINT_RANGE = np.radians([[-90, 150], [-95, 0], [-90, 90], [-114, 0]])
BRAKING_RESERVE = 0.9
JERK = 1e4
RAMP = (BRAKING_RESERVE * 25) ** 2 / (2 * JERK)  # speed lost while the deceleration ramps up at JERK
LOST = 2 * RAMP + BRAKING_RESERVE * 25 * 0.006
# A joint counts as being at a limit if it is closer to it than this. At this distance less 2 mrad, the highest speed
# from which the joint can still stop in time becomes 0.
AT_LIMIT_RAD = 2e-3 + (LOST**2 - RAMP**2) / (2 * BRAKING_RESERVE * 25)
RAMP_DOWN = np.arange(5) * JERK * TICK_S**2  # velocity changes per tick that can fall to 0 in 0, 1, 2... ticks
RAMP_DOWN_SUM = np.cumsum(RAMP_DOWN)  # total velocity change of each of these ramps


def limited(demanded, last, last_change, q, gain, acceleration=25.0):
    """Applies the limits of joint_limits.h: approach speed, common scaling to the speed limits, stopping distance,
    acceleration and jerk.

    Returns the velocity change after limiting.
    """
    speed = np.abs(demanded)
    a = BRAKING_RESERVE * acceleration
    linear = a / gain
    approach = np.where(speed <= linear, speed, np.sqrt(np.maximum(linear * (2 * speed - linear), 0)))
    allowed = np.minimum(VELOCITY_MAX, approach)
    scale = np.min(np.where(speed > allowed, allowed / np.maximum(speed, 1e-12), 1.0))
    room = np.maximum([JOINT_RANGE[:, 1] - q, q - JOINT_RANGE[:, 0]], 0)
    growth = np.array([np.maximum(last_change, 0), np.maximum(-last_change, 0)])
    ramp_s = growth / (JERK * TICK_S)
    room = np.maximum(room - ramp_s * (np.abs(last) + 0.5 * growth / TICK_S * ramp_s), 0)
    up, down = np.maximum(np.sqrt(2 * a * room + RAMP**2) - LOST, 0)
    way = np.clip(scale * demanded, -down, up) - last
    change = np.sign(way) * np.interp(np.abs(way), RAMP_DOWN_SUM, RAMP_DOWN)
    change = np.clip(change, last_change - JERK * TICK_S**2, last_change + JERK * TICK_S**2)
    return np.clip(change, -acceleration * TICK_S, acceleration * TICK_S)


def law(jacobian, hand, target, gain, weight, damping):
    """Evaluates control law (4) with the error in the target's frame, as oracle.law does, but for a single posture. In
    a loop of many thousands of ticks, the overhead of oracle.law's array operations would dominate."""
    back = DQ(-target if target[:4] @ hand[:4] < 0 else target).conj().hamiplus8()
    error = IDENTITY - back @ hand
    seen = back @ jacobian
    weighted = seen.T * weight
    normal = weighted @ seen + damping * np.eye(jacobian.shape[1])
    return np.linalg.solve(normal, weighted @ (gain * error))


def law_with_blocked_joints(jacobian, hand, target, q, *settings):
    """Evaluates control law (4), repeatedly leaving out each joint that is at a limit and would move beyond it, as
    joints_at_limit_solve() does."""
    free = np.ones(len(q), bool)
    above, below = JOINT_RANGE[:, 1] - q < AT_LIMIT_RAD, q - JOINT_RANGE[:, 0] < AT_LIMIT_RAD
    while True:
        demanded = np.zeros(len(q))
        if free.any():
            demanded[free] = law(jacobian[:, free], hand, target, *settings)
        blocked = ((demanded > 0) & above) | ((demanded < 0) & below)
        if not blocked.any():
            return demanded
        free &= ~blocked


def run(targets: np.ndarray, cooperating: np.ndarray, q0: np.ndarray) -> np.ndarray:
    """Runs the loop over targets (N, 8), one per tick. The arm brakes in every tick for which cooperating (N,) is
    false. Returns the end effector pose (N, 8) at each tick, before the command of that tick takes effect."""
    arm = oracle.hoap3()
    q, v, change = q0.astype(float).copy(), np.zeros(len(q0)), np.zeros(len(q0))
    hands = np.empty((len(targets), 8))
    for k, target in enumerate(targets):
        hand = vec8(arm.fkm(q))
        hands[k] = hand
        demanded = np.zeros(len(q))
        if cooperating[k]:
            demanded = law_with_blocked_joints(arm.pose_jacobian(q), hand, target, q, GAIN, WEIGHT, DAMPING)
        change = limited(demanded, v, change, q, GAIN)
        v = v + change
        q = q + v * TICK_S
    return hands
