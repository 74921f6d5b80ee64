"""A follower that uses mink. As in Pink (Caron et al.), each step of inverse kinematics is a quadratic program with
the joint limits as constraints. MuJoCo computes the arm's kinematics."""

from __future__ import annotations

import mink
import mujoco
import numpy as np

from comanip_dev.following.arm_model import ArmModel
from comanip_dev.following.loop import TICK_S
from comanip_dev.following.peer_loop import Velocities

ORIENTATION_COST = 0.01  # per rad; the position cost is 1 per m, so that 1 rad counts as much as 10 mm
DAMPING = 1e-3
SOLVER = "daqp"


def mjcf(arm: ArmModel) -> str:
    """Returns the arm as a MuJoCo model. The masses are arbitrary, because only the kinematics is used."""

    def numbers(values: np.ndarray) -> str:
        return " ".join(f"{value:.9g}" for value in values)

    opened, closed = [], []
    for i, ((rotation, way_m), axis) in enumerate(zip(arm.fixed, arm.axis, strict=True)):
        span = f"{arm.position_min_rad[i]:.9g} {arm.position_max_rad[i]:.9g}"
        opened.append(
            f'<body name="link{i}" pos="{numbers(way_m)}" quat="{numbers(rotation)}">'
            f'<joint name="joint{i}" type="hinge" axis="{numbers(axis)}" limited="true" range="{span}"/>'
            '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
        )
        closed.append("</body>")
    rotation, way_m = arm.effector
    site = f'<site name="hand" pos="{numbers(way_m)}" quat="{numbers(rotation)}"/>'
    body = "".join(opened) + site + "".join(closed)
    return f'<mujoco><compiler angle="radian"/><worldbody>{body}</worldbody></mujoco>'


def velocities(gain_per_s: float):
    """Returns a function that creates the follower. gain_per_s: desired rate of error reduction."""

    def make(
        arm: ArmModel, start_rad: np.ndarray, t_s: np.ndarray, target_m: np.ndarray, rotation: np.ndarray
    ) -> Velocities:
        model = mujoco.MjModel.from_xml_string(mjcf(arm))
        configuration = mink.Configuration(model)
        task = mink.FrameTask("hand", "site", 1.0, ORIENTATION_COST, gain=gain_per_s * TICK_S, lm_damping=DAMPING)
        most = {f"joint{i}": speed for i, speed in enumerate(arm.velocity_max_radps)}
        limits = [mink.ConfigurationLimit(model), mink.VelocityLimit(model, most)]
        still = np.zeros(arm.joint_count)
        low, high = arm.position_min_rad, arm.position_max_rad

        def step(target: int, measured_rad: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            configuration.update(np.clip(measured_rad, low, high))
            turn = mink.SO3(rotation[target])
            task.set_target(mink.SE3.from_rotation_and_translation(turn, target_m[target]))
            return mink.solve_ik(configuration, [task], TICK_S, SOLVER, limits=limits), still

        return step

    return make
