"""The groove carries a rod along the stand's length, but no further."""

from __future__ import annotations

import numpy as np
import plant_binding
import pytest
from scene_bench import ALONG_Y, GRAVITY_MPS2, ROD, Scene

_, lib = plant_binding.load()
STAND_AT = np.array([0.4, 0.2, -0.05])
ROD_AT = STAND_AT + [0, 0.02, 0.028]  # lying on top of the stand
HOLDER = {"start": (list(ROD_AT), (1, 0, 0, 0)), "damping_ratio": 1.0}


def on_stand() -> list[dict]:
    stand = {"kind": lib.OBJECT_STAND, "pose": (list(STAND_AT), (1, 0, 0, 0)), "size_m": [0.06, 0.12, 0.04]}
    return [{"kind": lib.OBJECT_ROD, "pose": (list(ROD_AT), ALONG_Y), "person_grip": lib.GRIP_FIXED}, stand]


def lead(scene: Scene, places_m) -> None:
    """Moves the hand from the rod's start to each position in turn, in half a second each."""
    last = np.zeros(3)
    for place in np.array(places_m):
        for n in range(1, 501):
            scene.aim(0, ROD_AT + last + 0.5 * (1 - np.cos(np.pi * n / 500)) * (place - last))
            scene.step()
        last = place


def test_no_groove_beyond_the_stand():
    """When the rod is raised, moved along its axis past the stand and lowered again, the hand carries the rod's whole
    weight."""
    with Scene([HOLDER], on_stand()) as scene:
        scene.step(300)
        assert scene.grip()
        lead(scene, [(0, 0, 0.03), (0, 0.25, 0.03), (0, 0.25, -0.004)])
        scene.step(1500)
        assert np.allclose(scene.hand_force(), [0, 0, -ROD["mass_kg"] * GRAVITY_MPS2], atol=1e-3)
        assert scene.thing()[0][2] < ROD_AT[2] - 0.004


@pytest.mark.parametrize(("shift_m", "falls"), [(0.03, False), (0.05, True)])
def test_a_rod_tips_over_the_stands_edge(shift_m, falls):
    """The rod is released with its middle 10 mm inside the stand's edge, or 10 mm past it, and falls only in the second
    case."""
    with Scene([HOLDER], on_stand()) as scene:
        scene.step(100)
        assert scene.grip()
        lead(scene, [(0, shift_m, 0)])
        scene.step(500)
        lib.scene_open_hand(scene.scene, 0)
        scene.step(1000)
        assert (scene.thing()[0][2] < ROD_AT[2] - 0.1) == falls
