"""Measures one case: a follower on one recording under one condition."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass

import numpy as np

from comanip_dev.following import metrics, rotations
from comanip_dev.following.arm_model import ArmModel
from comanip_dev.following.loop import LoopError, Run
from comanip_dev.following.recorded_hand import HandMotion, Recording
from comanip_dev.following.target import targets
from comanip_dev.following.tracker import Samples, Tracker, measure

BEGIN_S = 3.0  # start of the motion; by then the arm cooperates, and its transition to the task is complete
AFTER_S = 0.5  # duration of the hand's rest after the motion
REST_S = 20.0  # duration of the hand's rest in which the noise is measured
ACCELERATION_MAX_RADPS2 = 25.0
# The arm's start posture for each task, as in the scenarios, in degrees.
START_DEG = {"teleop": (60, -30, -10, -80), "mirror": (90, -5, 0, -90), "pour": (90, -60, 0, -100)}

# A follower is a function that computes the arm's motion from (arm, task, start posture, motion of the hand, tracker,
# the tracker's samples).
Follower = Callable[[ArmModel, str, np.ndarray, HandMotion, Tracker, Samples], Run]


@dataclass(frozen=True)
class Scene:
    """A recording, scaled into the arm's reach, and the task that the arm performs."""

    recording: Recording
    task: str
    position_scale: float
    rotation_scale: float

    @property
    def start_rad(self) -> np.ndarray:
        return np.radians(START_DEG[self.task])

    @property
    def motion(self) -> HandMotion:
        return HandMotion(self.recording, self.position_scale, self.rotation_scale, BEGIN_S, AFTER_S)


@dataclass(frozen=True)
class Figures:
    """The figures of a run. Errors are measured during the motion, relative to the instantaneous target."""

    rms_mm: float
    max_mm: float
    rms_deg: float
    delay_ms: float
    acceleration_mps2: float
    limit_percent: float

    def as_dict(self) -> dict[str, float]:
        return asdict(self)


def target_path(arm: ArmModel, scene: Scene, t_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns the target of the end effector at each time: positions (T, 3) and rotations (T, 4)."""
    start_m, start_rotation = arm.hand(scene.start_rad[None])
    return targets(scene.task, start_m[0], start_rotation[0], *scene.motion.displacement(t_s))


def follow(arm: ArmModel, scene: Scene, tracker: Tracker, follower: Follower) -> Figures:
    motion = scene.motion
    run = follower(arm, scene.task, scene.start_rad, motion, tracker, measure(tracker, motion))
    return judge(arm, scene, run)


def judge(arm: ArmModel, scene: Scene, run: Run) -> Figures:
    window = slice(round(scene.motion.begin_s / metrics.TICK_S), round(scene.motion.end_s / metrics.TICK_S))
    if not run.cooperating[window].any():
        raise LoopError("the arm did not cooperate")
    t_s = np.arange(len(run.cooperating)) * metrics.TICK_S
    path_m, rotation = arm.hand(run.position_rad)
    truth_m, truth_rotation = target_path(arm, scene, t_s)
    error_mm = metrics.errors_mm(path_m, truth_m)[window]
    turned = rotations.angle_between(rotation, truth_rotation)[window]
    command = run.command_radps[window]
    return Figures(
        rms_mm=metrics.rms(error_mm),
        max_mm=float(error_mm.max()),
        rms_deg=float(np.degrees(metrics.rms(turned))),
        delay_ms=metrics.delay_ms(path_m[window], truth_m[window]),
        acceleration_mps2=metrics.acceleration_rms_mps2(path_m[window]),
        limit_percent=100.0 * metrics.limit_share(command, arm.velocity_max_radps, ACCELERATION_MAX_RADPS2),
    )


def noise_at_rest_um(arm: ArmModel, task: str, tracker: Tracker, follower: Follower) -> float:
    """Returns the noise of the end effector while the person's hand is at rest."""
    motion = HandMotion(None, 1.0, 1.0, BEGIN_S, REST_S)
    start_rad = np.radians(START_DEG[task])
    run = follower(arm, task, start_rad, motion, tracker, measure(tracker, motion))
    if not run.cooperating.any():
        raise LoopError("the arm did not cooperate")
    path_m, _ = arm.hand(run.position_rad[round(BEGIN_S / metrics.TICK_S) :])
    return metrics.noise_um(path_m)
