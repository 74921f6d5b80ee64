"""A follower that uses Ruckig (Berscheid, Kroeger, "Jerk-limited Real-time Trajectory Generation with Arbitrary Target
States", RSS 2021), a trajectory generator for robot arms. Inverse kinematics computes target joint positions for
each sample, and Ruckig computes the time-optimal trajectory from the present reference to these positions."""

from __future__ import annotations

import numpy as np
from ruckig import InputParameter, OutputParameter, Ruckig

from comanip_dev.following.arm_model import ArmModel
from comanip_dev.following.case import ACCELERATION_MAX_RADPS2
from comanip_dev.following.loop import TICK_S
from comanip_dev.following.peer_loop import Velocities
from comanip_dev.following.posture_path import posture_path

JERK_MAX_RADPS3 = 10000.0  # default in an arm's description
GAIN_PER_S = 35.0  # gain on the difference of reference and measured positions, as in our control law


def velocities(velocity_share: float):
    """Returns a function that creates the follower. velocity_share: share of the target's estimated velocity that
    Ruckig is given as the velocity to reach. With 0, Ruckig plans to stop at each target."""

    def make(
        arm: ArmModel, start_rad: np.ndarray, t_s: np.ndarray, target_m: np.ndarray, rotation: np.ndarray
    ) -> Velocities:
        posture_rad, _ = posture_path(arm, start_rad, t_s, target_m)
        speed_radps = np.diff(posture_rad, axis=0, prepend=posture_rad[:1]) / np.median(np.diff(t_s))
        most = arm.velocity_max_radps
        goal_radps = np.clip(velocity_share * speed_radps, -0.99 * most, 0.99 * most)
        generator = Ruckig(arm.joint_count, TICK_S)
        way, reference = InputParameter(arm.joint_count), OutputParameter(arm.joint_count)
        way.max_velocity = most.tolist()
        way.max_acceleration = [ACCELERATION_MAX_RADPS2] * arm.joint_count
        way.max_jerk = [JERK_MAX_RADPS3] * arm.joint_count
        way.current_position = start_rad.tolist()

        def step(target: int, measured_rad: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            way.target_position = posture_rad[target].tolist()
            way.target_velocity = goal_radps[target].tolist()
            generator.update(way, reference)
            reference.pass_to_input(way)
            ahead_rad = np.array(reference.new_position) - measured_rad
            return GAIN_PER_S * ahead_rad, np.array(reference.new_velocity)

        return step

    return make
