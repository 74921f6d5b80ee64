"""Checks the crank: the turn count, and whether dry friction holds the weight of the handle. Energy and free
oscillation are checked in test_physics.py."""

from __future__ import annotations

import numpy as np
import plant_binding
import pytest
from scene_bench import ALONG_Y, GRAVITY_MPS2, Scene
from scipy.spatial.transform import Rotation

_, lib = plant_binding.load()
HINGE = np.array([0.5, 0.2, 0.0])
START = Rotation.from_quat([*ALONG_Y[1:], ALONG_Y[0]])
RADIUS_M, HANDLE_KG = 0.05, 0.1


def crank(**values) -> dict:
    pose = (list(HINGE), ALONG_Y)
    return {"kind": lib.OBJECT_CRANK, "pose": pose, "radius_m": RADIUS_M, "mass_kg": HANDLE_KG, **values}


@pytest.mark.parametrize("turns", [3.0, -2.0])
def test_turns_are_counted_with_their_sign(turns):
    """The turn count agrees with the angle of the handle, summed up step by step, and the hand's work equals the
    friction losses."""
    friction, damping, seconds = 0.03, 0.01, 4.0
    holder = {"start": (list(HINGE + [RADIUS_M, 0, 0]), (1, 0, 0, 0)), "stiffness_Npm": 2000.0, "damping_ratio": 1.0}
    with Scene([holder], [crank(friction_Nm=friction, damping_Nmspprad=damping)]) as scene:
        assert scene.grip()
        scene.step(500)
        angle, handle = 0.0, scene.point("POINT_OBJECT")
        work_J = loss_J = 0.0
        for n in range(1, round(seconds / scene.step_s) + 1):
            s = n * scene.step_s / seconds
            aim = 2 * np.pi * turns * (10 * s**3 - 15 * s**4 + 6 * s**5)
            scene.aim(0, HINGE + RADIUS_M * START.apply([np.cos(aim), np.sin(aim), 0]))
            scene.step()
            now = scene.point("POINT_OBJECT")
            seen = START.inv().apply(now - HINGE)
            turned = np.remainder(np.arctan2(seen[1], seen[0]) - angle + np.pi, 2 * np.pi) - np.pi
            work_J -= scene.hand_force() @ (now - handle)
            loss_J += friction * abs(turned) + damping * turned**2 / scene.step_s
            angle, handle = angle + turned, now
        scene.step()  # the count lags by one step
        assert lib.scene_crank_turns(scene.scene, 0) == pytest.approx(angle / (2 * np.pi), abs=1e-6)
        assert angle / (2 * np.pi) == pytest.approx(turns, abs=0.02)
        assert work_J == pytest.approx(loss_J, rel=0.01) and loss_J > 0.4


@pytest.mark.parametrize(("share", "moves"), [(0.95, True), (1.05, False)])
def test_dry_friction_holds_the_handle_up(share, moves):
    level_Nm = HANDLE_KG * GRAVITY_MPS2 * RADIUS_M  # torque of the handle's weight about the hinge when level
    with Scene([], [crank(friction_Nm=share * level_Nm)]) as scene:
        scene.step(500)
        assert (abs(lib.scene_crank_turns(scene.scene, 0)) > 0.01) == moves
