"""Lists the cases of a campaign and measures them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

import numpy as np

from comanip_dev.following import followers, plan
from comanip_dev.following.arm_model import ArmModel
from comanip_dev.following.case import START_DEG, Scene, follow, noise_at_rest_um
from comanip_dev.following.loop import LoopError
from comanip_dev.following.plan import Condition, Setting
from comanip_dev.following.recorded_hand import HEADER, Recording, read
from comanip_dev.following.results import Key, case_key, scene_key
from comanip_dev.following.scale import SHARE, largest_scale

ARM = "hoap3_right"


@dataclass(frozen=True)
class Case:
    """A follower to be measured under one condition. recording: None if the hand is at rest.
    position_scale: scale of the recording in this setting."""

    loop: str
    follower: str
    condition: Condition
    setting: Setting
    recording: Path | None = None
    position_scale: float = 1.0
    seed: int = 1

    @property
    def key(self) -> Key:
        name = self.recording.stem if self.recording else None
        return case_key(self.loop, self.follower, self.condition, self.setting, name, self.seed)


@dataclass(frozen=True)
class Choice:
    """The scope of a campaign."""

    conditions: tuple[Condition, ...]
    has_peers: bool


FULL = Choice(plan.CONDITIONS, True)
QUICK = Choice(plan.JUDGED, False)


@cache
def _arm() -> ArmModel:
    return ArmModel(ARM)


@cache
def _recording(path: Path) -> Recording:
    return read(path)


def recordings(folder: Path) -> tuple[list[Path], dict[str, str]]:
    """Returns the recorded hand motions in the folder, and the reason for each file that is skipped."""
    paths, left_out = [], {}
    for path in sorted(folder.glob("*.csv")):
        with path.open(encoding="utf-8-sig") as file:
            is_motion = file.readline().strip() == HEADER
        twin = path.stem.removesuffix("_raw")
        if not is_motion:
            left_out[path.stem] = "not a motion of a hand: its header differs"
        elif twin != path.stem and path.with_stem(twin).is_file():
            left_out[path.stem] = f"the same motion as {twin}"
        else:
            paths.append(path)
    return paths, left_out


def prepare(setting: Setting, path: Path) -> tuple[Key, dict]:
    """Returns the position scale of the recording in this setting, and the figures of the optimum at this scale."""
    from comanip_dev.following.optimum import optimum

    recording = _recording(path)
    start_rad = np.radians(START_DEG[setting.task])
    scale = SHARE * largest_scale(_arm(), setting.task, start_rad, recording, setting.rotation_scale)
    best = optimum(_arm(), Scene(recording, setting.task, scale, setting.rotation_scale))
    value = {"position_scale": scale, "followable": best.is_followable, **asdict(best)}
    return scene_key(setting, path.stem), value


def measure(case: Case) -> tuple[Key, dict]:
    """Measures a case in the loop without physics, and returns its key and figures. If the arm does not cooperate,
    returns the key and an error message."""
    follower = followers.named(case.follower)
    tracker = case.condition.tracker(case.seed)
    try:
        if case.recording is None:
            return case.key, {"noise_um": noise_at_rest_um(_arm(), case.setting.task, tracker, follower)}
        scene = Scene(_recording(case.recording), case.setting.task, case.position_scale, case.setting.rotation_scale)
        return case.key, follow(_arm(), scene, tracker, follower).as_dict()
    except LoopError as error:
        return case.key, {"error": str(error)}


def _with_rest(loop: str, follower: str, condition: Condition, setting: Setting, scenes: Sequence[tuple[Path, float]]):
    yield Case(loop, follower, condition, setting)
    for path, scale in scenes:
        for seed in plan.seeds(follower, condition):
            yield Case(loop, follower, condition, setting, path, scale, seed)


def all_cases(choice: Choice, scenes: dict[Setting, list[tuple[Path, float]]]) -> list[Case]:
    """Returns all cases. scenes: for each setting, the recordings that the arm can follow, with their scales. Cases
    with the former and the default follower, under the conditions that the criteria judge, also run in ODE."""
    cases: list[Case] = []
    for condition in choice.conditions:
        for follower in plan.FIRMWARE:
            cases += _with_rest(plan.LOOP, follower, condition, plan.TELEOP, scenes[plan.TELEOP])
    for setting in plan.SETTINGS[1:]:
        for follower in plan.FIRMWARE:
            cases += _with_rest(plan.LOOP, follower, plan.FAST, setting, scenes[setting])
    for follower in (plan.FORMER, plan.DEFAULT):
        for condition in plan.JUDGED:
            cases += _with_rest(plan.ODE, follower, condition, plan.TELEOP, scenes[plan.TELEOP])
        for setting in plan.SETTINGS[1:]:
            cases += [Case(plan.ODE, follower, plan.FAST, setting, *scene) for scene in scenes[setting]]
    if choice.has_peers:
        for condition in plan.JUDGED:
            for peer in plan.PEER_NAMES:
                cases += _with_rest(plan.LOOP, peer, condition, plan.TELEOP, scenes[plan.TELEOP])
    return cases
