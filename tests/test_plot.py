"""Pictures of a run are complete and show the right data, and missing data is reported in one line. The references are
closed forms, scipy and the simulator's scenario files."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import synthetic_run
from comanip.core.arm import Arm
from comanip.plotting import geometry
from comanip.plotting.__main__ import main
from comanip.plotting.run_data import RunDataError, read_run, read_trace
from comanip.plotting.scenes import SCENES
from hoap3 import STOPS_DEG
from matplotlib.image import imread
from scipy.spatial.transform import Rotation
from simulation import EXPERIMENTS, experiment
from simulation import run as simulate

PNG = b"\x89PNG\r\n\x1a\n"
ALWAYS = {"experiment", "paths", "tracking", "orientation", "joints", "clearance"}
ALSO = {"crank": {"force", "crank"}, "teleop": {"force"}}


# ---- reading


def test_trace_is_read_as_written(tmp_path):
    folder = synthetic_run.write(tmp_path, "teleop", duration_s=1.0)
    written = synthetic_run.columns("teleop", 1.0)
    read = read_trace(folder / "trace.csv")
    assert set(read) == set(synthetic_run.COLUMNS) - {"mode"}
    for name, column in read.items():
        np.testing.assert_allclose(column, written[name], rtol=1e-6, atol=1e-9, err_msg=name)


def broken(text: str, how: str) -> str:
    lines = text.splitlines(keepends=True)
    return {
        "empty": "",
        "header only": lines[0],
        "cut in a line": text[: len(text) - 10],
        "short line": "".join([*lines[:5], "0.004,ready\n", *lines[6:]]),
        "word": text.replace("0.136", "nonsense", 1),
        "another table": "a,b\n1,2\n",
    }[how]


@pytest.mark.parametrize(
    ("how", "expected"),
    [
        ("empty", "trace.csv:1: no column t_s"),
        ("header only", "has no rows"),
        ("cut in a line", "trace.csv:101: the last line is incomplete"),
        ("short line", "trace.csv:6: 2 cells, expected 56"),
        ("word", "not a number"),
        ("another table", "trace.csv:1: no column t_s"),
    ],
)
def test_broken_trace_gives_one_line_and_status_1(tmp_path, capsys, how, expected):
    folder = synthetic_run.write(tmp_path, "mirror", duration_s=1.0)
    trace = folder / "trace.csv"
    trace.write_text(broken(trace.read_text(), how))
    assert main([str(folder)]) == 1
    error = capsys.readouterr().err
    assert expected in error and error.count("\n") == 1, error


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (None, "summary.json: cannot be read"),
        ('{"scenario": "pour"', "summary.json: not valid JSON"),
        ("[]", "summary.json: scenario is None, expected str"),
        ('{"scenario": "pour", "result": "pass", "seed": "1"}', "seed is '1', expected int"),
    ],
)
def test_broken_summary_gives_one_line_and_status_1(tmp_path, capsys, text, expected):
    folder = synthetic_run.write(tmp_path, "pour", duration_s=0.1)
    (folder / "summary.json").unlink()
    if text is not None:
        (folder / "summary.json").write_text(text)
    assert main([str(folder)]) == 1
    error = capsys.readouterr().err
    assert expected in error and error.count("\n") == 1, error


def test_no_folder(tmp_path, capsys):
    assert main([str(tmp_path / "none")]) == 1
    assert capsys.readouterr().err == f"comanip.plotting: {tmp_path / 'none'}: there is no such folder\n"


def test_first_of_several_events_and_modes(tmp_path):
    changes = [{"t_s": 2.0, "name": "b"}, {"t_s": 1.0, "name": "a"}, {"t_s": 3.0, "name": "a"}]
    run = read_run(synthetic_run.write(tmp_path, "own", duration_s=4.0, events=changes))
    assert [event.name for event in run.events] == ["a", "b", "a"]
    assert run.event_s("a") == 1.0 and run.event_s("none", "b") == 2.0 and run.event_s("none") is None
    assert run.modes() == [(0.0, 0.5, "ready"), (0.5, 3.99, "cooperating")]


# ---- geometry


def test_rotations_against_scipy(rng):
    a, b = (Rotation.random(200, random_state=rng) for _ in range(2))
    vector = rng.normal(size=(200, 3))
    wxyz = [r.as_quat(scalar_first=True) * rng.choice([-1.0, 1.0], (200, 1)) for r in (a, b)]
    np.testing.assert_allclose(geometry.rotate(wxyz[0], vector), a.apply(vector), atol=1e-12)
    expected = np.degrees((a.inv() * b).magnitude())
    np.testing.assert_allclose(geometry.angle_between_deg(*wxyz), expected, atol=1e-10)


def test_small_angles_are_not_lost():
    turned = Rotation.from_rotvec([[0.0, 0.0, 1e-9]]).as_quat(scalar_first=True)
    angle = geometry.angle_between_deg(turned, np.array([[1.0, 0.0, 0.0, 0.0]]))
    np.testing.assert_allclose(angle, np.degrees(1e-9), rtol=1e-6)


def test_arm_points_match_the_manual():
    """At (90, 0, 0, -90) deg the upper arm hangs down and the forearm points forward, with links of 0.111 and 0.171
    m."""
    points = geometry.arm_points_m(np.radians([[90.0, 0.0, 0.0, -90.0]]))[0]
    shoulder, elbow, hand = [-0.035, -0.111, 0.125], [-0.035, -0.111, 0.014], [0.136, -0.111, 0.014]
    np.testing.assert_allclose(points[0], shoulder, atol=1e-6)
    np.testing.assert_allclose(points[-2], elbow, atol=1e-6)
    np.testing.assert_allclose(points[-1], hand, atol=1e-6)


def test_link_lengths_hold_in_any_posture(rng):
    low, high = np.radians(STOPS_DEG).T
    points = geometry.arm_points_m(rng.uniform(low, high, (100, 4)))
    np.testing.assert_allclose(np.linalg.norm(points[:, -2] - points[:, 0], axis=1), 0.111, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(points[:, -1] - points[:, -2], axis=1), 0.171, atol=1e-6)


def test_drawn_joint_limits_match_the_manual():
    arm = Arm.named(geometry.ARM)
    usable = np.stack([arm.position_min_rad, arm.position_max_rad], axis=1)
    np.testing.assert_allclose(np.degrees(usable), STOPS_DEG + [1.0, -1.0], atol=1e-4)
    np.testing.assert_allclose(arm.velocity_max_radps, 4.76, atol=0.005)


# ---- pictures


@pytest.fixture(autouse=True)
def coarse_pictures(monkeypatch):
    monkeypatch.setattr("comanip.plotting.style.DPI", 40)


@pytest.mark.parametrize("scenario", ["teleop", "crank"])
def test_pictures_of_each_experiment(tmp_path, capsys, scenario):
    folder = synthetic_run.write(tmp_path, scenario)
    assert main([str(folder)]) == 0
    pictures = {path.stem: path.read_bytes() for path in (folder / "report").iterdir()}
    assert set(pictures) == ALWAYS | ALSO[scenario]
    assert all(data.startswith(PNG) and len(data) > 3_000 for data in pictures.values())
    for path in (folder / "report").iterdir():
        paper = imread(path)[..., :3]
        edges = (paper[0], paper[-1], paper[:, 0], paper[:, -1])
        assert all(np.all(edge == 1.0) for edge in edges), f"{path.name}: the drawing is cut off at the edge"


@pytest.mark.parametrize("scenario", ["pour", "mirror", "handover", "own"])
def test_snapshots_and_curves_of_each_experiment(tmp_path, scenario):
    """The snapshots show the arm's posture at the times of the scenario's events."""
    from comanip.plotting import experiment as picture

    run = read_run(synthetic_run.write(tmp_path, scenario))
    panels = picture.experiment(run).axes[:4]
    times = [float(re.match(r"\(.\) ([\d.]+) s", panel.get_title())[1]) for panel in panels]
    expected = [1.0, 3.0, 5.0, 7.0] if scenario != "own" else np.linspace(0.5, 7.99, 5)[1:]
    np.testing.assert_allclose(times, expected, atol=0.06)
    assert len({(panel.get_xlim(), panel.get_ylim()) for panel in panels}) == 1


def test_a_stale_picture_is_removed(tmp_path):
    folder = synthetic_run.write(tmp_path, "mirror", duration_s=1.0)
    (folder / "report").mkdir()
    (folder / "report" / "water.png").write_bytes(PNG)
    assert main([str(folder)]) == 0
    assert not (folder / "report" / "water.png").exists()


def test_a_run_without_targets_and_events_is_drawn(tmp_path):
    """A run that never cooperated has neither targets nor events, but is drawn nevertheless."""
    folder = tmp_path / "run"
    idle = [{"t_s": 0.0, "mode": "idle", "reason": "waiting_for_tracker"}]
    synthetic_run.write(folder, "mirror", duration_s=0.4, events=[], modes=idle)
    assert main([str(folder)]) == 0
    assert not (folder / "report" / "tracking.png").exists() and (folder / "report" / "joints.png").exists()


def test_curves_and_limits_match_the_run(tmp_path):
    from comanip.plotting import time_plots

    checks = [
        {"name": name, "value": 1.0, "limit": limit, "unit": unit, "pass": True}
        for name, limit, unit in (("force_rms", 4.5, "N"), ("force_peak", 13.0, "N"), ("turns", 3, "turn"))
    ]
    run = read_run(synthetic_run.write(tmp_path, "mirror", checks=checks))
    x, error = time_plots.tracking(run).axes[:2]
    np.testing.assert_allclose(error.lines[0].get_ydata()[-1], -2.0, atol=1e-3)  # synthetic_run lags by 2 mm
    np.testing.assert_allclose(x.lines[0].get_ydata()[-1], 168.0, atol=1e-3)
    force = time_plots.force(run).axes[0]
    np.testing.assert_allclose(np.nanmax(force.lines[0].get_ydata()), 5.0)  # the norm of (3, 4, 0) N
    levels = {float(line.get_ydata()[0]): line.get_label() for line in force.lines[1:] if line.get_label()[0] != "_"}
    assert levels == {4.5: "force rms: 4.5 N", 13.0: "force peak: 13 N"}
    unlimited = time_plots.force(read_run(synthetic_run.write(tmp_path / "other", "mirror"))).axes[0]
    assert len([line for line in unlimited.lines if line.get_label()[0] != "_"]) == 1, "unset limits are not drawn"


def test_labels_are_spread_in_order(rng):
    from comanip.plotting.style import spread

    for count in (1, 2, 7, 30):
        desired = np.sort(rng.uniform(0.0, 10.0, count))
        places = spread(desired, 0.3, 0.0, 10.0)
        assert np.all(np.diff(places) >= 0.3 - 1e-9)
        assert places.min() >= -1e-9 and places.max() <= 10.0 + 1e-9
    np.testing.assert_allclose(spread([1.0, 5.0], 0.3, 0.0, 10.0), [1.0, 5.0])
    crowded = spread(np.full(50, 9.0), 0.3, 0.0, 10.0)
    assert np.all(np.diff(crowded) > 0.1) and crowded.max() <= 10.0 + 1e-9


def test_importing_the_package_does_not_import_matplotlib():
    code = "import sys, comanip, comanip.core, comanip.plotting.__main__; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


# ---- the scenario data in the pictures


def numbers(text: str, key: str) -> list[float]:
    return [float(value) for value in re.findall(rf"\b{key}: ([-\d.]+)", text)]


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_drawn_sizes_match_the_scenario_file(tmp_path, name):
    simulate(tmp_path, "--scenario", experiment(name), "--duration", 2)
    text, run = re.sub(r"#.*", "", experiment(name).read_text()), read_run(tmp_path)
    if name == "pour":
        assert run.thing is None
    else:
        assert numbers(text, "length_m") == [run.thing.length_m] and run.thing.radius_m in numbers(text, "radius_m")
        assert run.thing.kind == ("crank" if name == "crank" else "rod")
    cup_row = r"cup:\s*\{radius_m: ([\d.]+), height_m: ([\d.]+).*?mount_m: \[(.*?)\],\s*mount_rotation: \[(.*?)\]"
    mounts = re.findall(cup_row, text, re.DOTALL)
    assert len(mounts) == len(run.cups) == (2 if name == "pour" else 0)
    for (radius, height, mount, turns), cup in zip(mounts, run.cups, strict=True):
        assert (float(radius), float(height)) == (cup.radius_m, cup.height_m)
        assert tuple(map(float, mount.split(","))) == cup.mount_m
        turn = Rotation.identity()
        for axis, angle in re.findall(r"axis: (\w), angle_deg: ([-\d.]+)", turns):
            turn = turn * Rotation.from_euler(axis, float(angle), degrees=True)
        np.testing.assert_allclose(cup.axis, turn.apply([0.0, 0.0, 1.0]), atol=1e-8)


@pytest.mark.parametrize(
    ("name", "curves"), [("pour", "particles"), ("mirror", "object's distance"), ("crank", "turns")]
)
def test_a_custom_scene_is_drawn_with_its_objects(tmp_path, name, curves):
    path = tmp_path / "mine.yaml"
    path.write_text(re.sub(r"^name: .*", "name: mine", experiment(name).read_text(), flags=re.MULTILINE))
    simulate(tmp_path / "out", "--scenario", path, "--duration", 2)
    from comanip.plotting import experiment as picture

    upper = picture.experiment(read_run(tmp_path / "out")).axes[4]
    assert upper.get_ylabel().startswith(curves)


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_instants_are_steps_of_the_scenario(name):
    """Each instant at which a snapshot is drawn is either a grip event of the scene (holds) or a named step of the
    scenario file."""
    text = experiment(name).read_text()
    for event, _, _ in SCENES[name].instants:
        what = event.partition(".")[2]
        assert what == "holds" or re.search(rf"name: {what}\b", text), event


def test_a_read_error_names_the_path(tmp_path):
    with pytest.raises(RunDataError, match=re.escape(str(tmp_path / "trace.csv"))):
        read_trace(Path(tmp_path) / "trace.csv")
