"""Checks the effects of loads on grips: torques at the robot's joints, deflection of the gripper's pads, slip at the
limit of the torque about the jaws, and the opening of a hand by a shock."""

from __future__ import annotations

import hoap3
import numpy as np
import plant_binding
import pytest
from scene_bench import ALONG_Y, GRAVITY_MPS2, Scene

_, lib = plant_binding.load()
CHECK_DEG = (90, 0, 0, -90)
GRIPPER = np.array([0.166, -0.111, 0.014])  # 30 mm in front of the end effector in the manual's check posture
FREE_PLACE = np.array([0.4, 0.2, 0.0])  # far from the arm and the ground


def rod(at, **values) -> dict:
    return {"kind": lib.OBJECT_ROD, "pose": (list(at), ALONG_Y), **values}


def person(at, **values) -> dict:
    return {"start": (list(at), (1, 0, 0, 0)), **values}


@pytest.mark.parametrize("kind", ["GRIP_BALL", "GRIP_FIXED"])
def test_the_arms_joints_bear_what_the_gripper_holds(kind):
    """The joint torques equal the arm's own gravity torques plus J^T times the rod's weight, where the Jacobian J is
    computed with numpy."""
    q, mass = np.radians([80, -30, 15, -70]), 0.25
    hand = hoap3.frames(q)[4]
    gripper = hand[:3, :3] @ [0, 0, 0.03] + hand[:3, 3]
    thing = rod(gripper, held_by_robot=True, mass_kg=mass, robot_grip=getattr(lib, kind))
    with Scene([], [thing], start_deg=np.degrees(q).tolist()) as scene:
        scene.step(2000)
        measured = [lib.arm_plant_torque_Nm(scene.arm, i) for i in range(4)]

    def height(q):
        frame = hoap3.frames(q)[4]
        return (frame[:3, :3] @ [0, 0, 0.03] + frame[:3, 3])[2]

    slope = np.array([(height(q + 1e-6 * e) - height(q - 1e-6 * e)) / 2e-6 for e in np.eye(4)])
    assert np.abs(slope).max() > 0.05
    assert np.allclose(measured, hoap3.holding_torque(q) + mass * GRAVITY_MPS2 * slope, atol=1e-3)


@pytest.mark.parametrize("kind", ["GRIP_BALL", "GRIP_FIXED"])
def test_pads_deflect_as_springs(kind):
    """A rod of 0.3 kg held in its middle sinks by its weight divided by the stiffness."""
    thing = rod(GRIPPER, held_by_robot=True, mass_kg=0.3, robot_grip=getattr(lib, kind))
    with Scene([], [thing], start_deg=CHECK_DEG, gripper={"stiffness_Npm": 1500.0}) as scene:
        scene.step(2000)
        sunk = scene.point("POINT_ROBOT_GRIPPER") - scene.thing()[0]
        assert np.allclose(sunk, [0, 0, 0.3 * GRAVITY_MPS2 / 1500.0], atol=2e-6)
        assert lib.scene_gripper_force_N(scene.scene) == pytest.approx(0.3 * GRAVITY_MPS2, rel=1e-4)


@pytest.mark.parametrize(("limit_share", "lost"), [(0.97, 1), (1.03, 0)])
def test_a_fixed_grip_slips_at_its_torque_limit(limit_share, lost):
    """A rod that is gripped 60 mm from its middle loads the jaws with a torque of its weight times 60 mm. The rod slips
    if this torque exceeds the limit."""
    mass, lever = 0.4, 0.06
    limit = limit_share * mass * GRAVITY_MPS2 * lever
    thing = rod(GRIPPER + [0, lever, 0], held_by_robot=True, mass_kg=mass, robot_grip=lib.GRIP_FIXED)
    gripper = {"torque_limit_Nm": limit, "stiffness_Npm": 1e5, "damping_Nspm": 1e3}
    with Scene([], [thing], start_deg=CHECK_DEG, gripper=gripper) as scene:
        for n in range(1, 1001):  # the weight grows slowly, so that nothing oscillates
            scene.set_gravity(-GRAVITY_MPS2 * n / 1000)
            scene.step()
        scene.step(300)
        assert scene.times("robot.lost") == lost == 1 - int(lib.scene_robot_holds(scene.scene))


@pytest.mark.parametrize(("shock_steps", "lost"), [(1, 0), (40, 1)])
def test_a_shock_of_one_step_does_not_open_the_hand(shock_steps, lost):
    """A force of three times the hand's limit does not open the hand if it lasts for 1 ms, but does if it lasts for 40
    ms. The hands have no stiffness, so the force on the rod results only from the acceleration of the pulling hand."""
    places = [FREE_PLACE - [0, 0.1, 0], FREE_PLACE + [0, 0.1, 0]]
    limp = {"stiffness_Npm": 0.0, "mass_kg": 1.5}
    people = [person(places[0], grip_force_limit_N=10.0, **limp), person(places[1], **limp)]
    with Scene(people, [rod(FREE_PLACE, mass_kg=0.001)]) as scene:
        scene.set_gravity(0.0)
        assert scene.grip(0) and scene.grip(1)
        aim, speed, peak_N = places[1].copy(), 0.0, 0.0
        for n in range(100):
            # The aim's acceleration of 40 m/s^2 applies 60 N to the pulling hand of 1.5 kg. This force accelerates two
            # hands of equal mass, so 30 N act on the other hand.
            speed += 40.0 * scene.step_s if n < shock_steps else 0.0
            aim = aim + [0, speed * scene.step_s, 0]
            scene.aim(1, aim)
            scene.step()
            peak_N = max(peak_N, np.linalg.norm(scene.hand_force(0)))
        assert peak_N == pytest.approx(30.0, rel=0.01)
        assert scene.times("person0.lost") == lost


def test_a_hand_holds_one_object_and_never_a_stand():
    stand = {"kind": lib.OBJECT_STAND, "pose": (list(FREE_PLACE), (1, 0, 0, 0))}
    with Scene([person(FREE_PLACE)], [rod(FREE_PLACE), rod(FREE_PLACE), stand]) as scene:
        assert not scene.grip(0, 2)
        assert scene.grip(0, 1) and not scene.grip(0, 0)


def test_held_from_the_start():
    with Scene([], [rod(GRIPPER, held_by_robot=True)], start_deg=CHECK_DEG) as scene:
        assert lib.scene_robot_holds(scene.scene)
        scene.step(1000)
        assert lib.scene_robot_holds(scene.scene)
        assert scene.times("object0.dropped") == 0 == scene.times("robot.closed")
