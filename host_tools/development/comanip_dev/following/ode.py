"""Computes the figures from runs of the simulator, which includes the bus, the drives and the arm's dynamics in ODE."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from comanip_dev.experiments.campaign import Job, Outcome
from comanip_dev.following import metrics, rotations
from comanip_dev.following.arm_model import ArmModel
from comanip_dev.following.case import ACCELERATION_MAX_RADPS2, AFTER_S, BEGIN_S, REST_S, START_DEG, Figures
from comanip_dev.following.followers import PARAMETERS
from comanip_dev.following.loop import START_S, LoopError
from comanip_dev.following.plan import Condition, Setting
from comanip_dev.following.target import targets
from comanip_dev.following.tracker import HAND_START_M, NOISE_RAD_PER_M

# The person's hand plays the recording without tremor. The scene contains only the hand and the arm.
SCENE = """\
# Written by comanip_dev.following: the person's hand and the arm, without objects.
name: following
summary: the robot's hand follows a recorded hand
duration_s: {duration_s:.3f}
arm: {{model: hoap3_right, start_deg: [{start_deg}]}}
people:
  person:
    tracked: true
    tremor_mm: 0
    position_m: [{position_m}]
    rotation: [{{axis: y, angle_deg: 90}}, {{axis: z, angle_deg: 180}}]
    program:
      - {{do: rest, at_s: {begin_s:g}, duration_s: {rest_s:g}}}
    program_with_recording:
      - {{do: play, at_s: {begin_s:g}, position_scale: {position_scale:.6f}, rotation_scale: {rotation_scale:g}}}
      - {{do: rest, duration_s: {after_s:g}}}
operator:
  - {{do: select, task: {task}}}
  - {{do: start, at_s: {start_s:g}}}
"""
LONGEST_S = 120.0


def job(
    out: Path,
    follower: str,
    condition: Condition,
    setting: Setting,
    recording: Path | None,
    position_scale: float,
    seed: int = 1,
) -> Job:
    """Returns the job for one case. out: folder for the scene and the run's files."""
    out.mkdir(parents=True, exist_ok=True)
    scene = out / "scene.yaml"
    text = SCENE.format(
        duration_s=LONGEST_S,
        start_deg=", ".join(f"{angle:g}" for angle in START_DEG[setting.task]),
        position_m=", ".join(f"{x:g}" for x in HAND_START_M),
        begin_s=BEGIN_S,
        rest_s=REST_S,
        position_scale=position_scale,
        rotation_scale=setting.rotation_scale,
        after_s=AFTER_S,
        task=setting.task,
        start_s=START_S,
    )
    scene.write_text(text)
    tracker = condition.tracker()
    noise_deg = np.degrees(NOISE_RAD_PER_M * tracker.noise_m)
    arguments = ("--rate", f"{condition.rate_hz:g}", "--latency-ms", f"{condition.latency_ms:g}")
    arguments += ("--noise-mm", f"{condition.noise_mm:g}", "--noise-deg", f"{noise_deg:g}")
    parameters = tuple(PARAMETERS[follower].items())
    return Job(str(scene), seed, out, recording, parameters=parameters, arguments=arguments)


def _columns(trace: np.ndarray, *names: str) -> np.ndarray:
    return np.stack([trace[name] for name in names], axis=1)


def _pose_names(who: str) -> list[str]:
    return [*(f"{who}_{axis}_m" for axis in "xyz"), *(f"{who}_q{axis}" for axis in "wxyz")]


def _pose(trace: np.ndarray, who: str) -> tuple[np.ndarray, np.ndarray]:
    rows = _columns(trace, *_pose_names(who))
    return rows[:, :3], rows[:, 3:]


def read_trace(path: Path, joint_count: int) -> np.ndarray:
    """Returns the time, the poses of the end effector and of the person's hand, and the commands, for all ticks in
    which the arm cooperates. Raises LoopError if the arm never cooperates."""
    names = ["t_s", *_pose_names("hand"), *_pose_names("person"), *(f"dq{i}_command_radps" for i in range(joint_count))]
    with path.open() as file:
        header = file.readline().strip().split(",")
        cooperating = [line for line in file if line.split(",", 2)[1] == "cooperating"]
    if not cooperating:
        raise LoopError(f"{path}: the arm did not cooperate")
    rows = np.loadtxt(cooperating, delimiter=",", usecols=[header.index(name) for name in names], ndmin=2)
    return np.rec.fromarrays(rows.T, names=names)


def judge(arm: ArmModel, task: str, outcome: Outcome, end_s: float) -> Figures:
    """Returns the figures of a run up to end_s, the end of the recorded motion. Raises LoopError if the run ended
    earlier."""
    trace = read_trace(outcome.job.out / "trace.csv", arm.joint_count)
    path_m, rotation = _pose(trace, "hand")
    person_m, turned = _pose(trace, "person")
    turn = rotations.multiply(turned, rotations.conjugate(turned[0]))
    truth_m, truth_rotation = targets(task, path_m[0], rotation[0], person_m - person_m[0], turn)
    window = (trace["t_s"] >= BEGIN_S) & (trace["t_s"] < end_s)
    if trace["t_s"][-1] < end_s - 0.01:
        raise LoopError(f"{outcome.job.out}: ended at {trace['t_s'][-1]:.2f} s, before {end_s:.2f} s: {outcome.reason}")
    error_mm = metrics.errors_mm(path_m, truth_m)[window]
    command = _columns(trace, *(f"dq{i}_command_radps" for i in range(arm.joint_count)))[window]
    return Figures(
        rms_mm=metrics.rms(error_mm),
        max_mm=float(error_mm.max()),
        rms_deg=float(np.degrees(metrics.rms(rotations.angle_between(rotation, truth_rotation)[window]))),
        delay_ms=metrics.delay_ms(path_m[window], truth_m[window]),
        acceleration_mps2=metrics.acceleration_rms_mps2(path_m[window]),
        limit_percent=100.0 * metrics.limit_share(command, arm.velocity_max_radps, ACCELERATION_MAX_RADPS2),
    )


def noise_um(arm: ArmModel, outcome: Outcome) -> float:
    """Returns the noise of the end effector in a run with the hand at rest."""
    trace = read_trace(outcome.job.out / "trace.csv", arm.joint_count)
    path_m, _ = _pose(trace, "hand")
    return metrics.noise_um(path_m[(trace["t_s"] >= BEGIN_S) & (trace["t_s"] < BEGIN_S + REST_S)])
