"""The loop as it would be without a world: dqrobotics' kinematics in double precision, drives that do at once what they
are told, no bus, no encoder. Written from the paper and from the headers' description of the limits."""

from __future__ import annotations

import numpy as np
from dqrobotics import vec8

import oracle

TICK_S = 1e-3
VELOCITY_MAX = 4.76
JOINT_RANGE = np.radians([[-90, 150], [-95, 0], [-90, 90], [-114, 0]])
BRAKING_RESERVE = 0.9
AT_LIMIT_RAD = 2e-3 + 0.5 * 0.9 * 25 * 0.006**2  # and where the stopping speed is 0


def limited(wanted, last, q, gain, acceleration=25.0, delay_s=0.005):
    """joint_limits.h: approach speed, speed limit in common proportion, stopping distance, acceleration."""
    speed = np.abs(wanted)
    a = BRAKING_RESERVE * acceleration
    linear = a / gain
    approach = np.where(speed <= linear, speed, np.sqrt(np.maximum(linear * (2 * speed - linear), 0)))
    allowed = np.minimum(VELOCITY_MAX, approach)
    scale = np.min(np.where(speed > allowed, allowed / np.maximum(speed, 1e-12), 1.0))
    room = np.maximum([JOINT_RANGE[:, 1] - q, q - JOINT_RANGE[:, 0]], 0)
    up, down = np.maximum(np.sqrt(2 * a * room) - a * (delay_s + TICK_S), 0)
    v = np.clip(scale * wanted, -down, up)
    return np.clip(v, last - acceleration * TICK_S, last + acceleration * TICK_S)


def law_with_blocked_joints(jacobian, hand, target, q, *settings):
    """Law (4) over the joints that are free to do what it asks: joint_limits_ends()."""
    free = np.ones(len(q), bool)
    while True:
        wanted = np.zeros(len(q))
        if free.any():
            wanted[free] = oracle.law(jacobian[None][:, :, free], hand[None], target[None], *settings)[0]
        blocked = ((wanted > 0) & (JOINT_RANGE[:, 1] - q < AT_LIMIT_RAD)) | ((wanted < 0) & (q - JOINT_RANGE[:, 0] < AT_LIMIT_RAD))
        if not blocked.any():
            return wanted
        free &= ~blocked


def run(targets: np.ndarray, cooperating: np.ndarray, q0: np.ndarray, gain=35.0, weight=None, damping=1e-2,
        error_frame="target") -> np.ndarray:
    """targets (N, 8), one a tick; cooperating (N,) bool: elsewhere the arm brakes. Returns the hand (N, 8) at each tick,
    before that tick's command acts."""
    arm = oracle.hoap3()
    weight = np.r_[[0.01] * 4, [100.0] * 4] if weight is None else weight
    q, v = q0.astype(float).copy(), np.zeros(len(q0))
    hands = np.empty((len(targets), 8))
    for k, target in enumerate(targets):
        hand = vec8(arm.fkm(q))
        hands[k] = hand
        wanted = np.zeros(len(q))
        if cooperating[k]:
            wanted = law_with_blocked_joints(arm.pose_jacobian(q), hand, target, q, gain, weight, damping, error_frame)
        v = limited(wanted, v, q, float(np.max(gain)))
        q = q + v * TICK_S
    return hands
