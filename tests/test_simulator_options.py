"""The simulator's options have their documented effects, summary.json keeps its format, and both agree with the bus."""

from __future__ import annotations

import bus_log
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from simulation import SCENARIOS, Run, modes, recording_csv, run

# ---- summary.json is a contract

CONTRACT = {
    "scenario": str, "result": str, "reason": str, "seed": int, "sim_s": float, "wall_s": float, "ticks": int,
    "tracking": {"rms_position_mm": float, "max_position_mm": float, "rms_orientation_deg": float,
                 "max_orientation_deg": float},
    "reach": {"out_of_reach_s": float},
    "limits": {"violations": int},
    "bus": {"frames": int, "load_percent_mean": float, "load_percent_peak": float, "dropped": int},
    "tracker": {"samples": int, "lost": int, "longest_gap_ms": float},
    "modes": [{"t_s": float, "mode": str, "reason": str}],
    "checks": [{"name": str, "value": float, "limit": float, "unit": str, "pass": bool}],
}  # fmt: skip
BEYOND_THE_CONTRACT = {
    "summary.tracker.range_errors", "summary.tracking.followable", "summary.bus.profile",
    *(f"summary.{key}" for key in ("recording", "second_recording", "people", "gripper", "clearance", "water", "events",
                                   "law", "object", "cups", "rest", "latency", "port")),
    "summary.checks[].orientation_rms_deg",
}  # fmt: skip


def assert_shape(value: object, shape: object, path: str) -> None:
    if isinstance(shape, dict):
        assert isinstance(value, dict), path
        assert [key for key in value if f"{path}.{key}" not in BEYOND_THE_CONTRACT] == list(shape), path
        for key, part in shape.items():
            assert_shape(value[key], part, f"{path}.{key}")
    elif isinstance(shape, list):
        assert isinstance(value, list) and value, path
        for item in value:
            assert_shape(item, shape[0], f"{path}[]")
    else:
        accepted = (int, float) if shape is float else shape  # a whole number may lack the decimal point
        assert isinstance(value, accepted) and isinstance(value, bool) == (shape is bool), f"{path} is {value!r}"


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_summary_has_the_fields_of_the_contract(tmp_path, scenario):
    done = run(tmp_path / "out", "--scenario", scenario, "--seed", 5).require_pass()
    summary = done.summary
    assert_shape(summary, CONTRACT, "summary")
    assert (summary["scenario"], summary["result"], summary["seed"]) == (scenario, "pass", 5)
    assert summary["ticks"] == round(1000 * summary["sim_s"]) == done.trace.read_bytes().count(b"\n") - 1
    assert all(check["pass"] for check in summary["checks"])
    tracking = summary["tracking"]
    assert 0 < tracking["rms_position_mm"] <= tracking["max_position_mm"]
    assert 0 < tracking["rms_orientation_deg"] <= tracking["max_orientation_deg"] <= 180
    assert 0 < summary["bus"]["load_percent_mean"] < summary["bus"]["load_percent_peak"] < 100
    times = [change["t_s"] for change in summary["modes"]]
    assert times == sorted(times)


# ---- options


def poses_of(done: Run) -> tuple[np.ndarray, np.ndarray]:
    """Returns the timestamp of each HandPose frame, and whether the frame contains a valid pose."""
    poses = bus_log.read(done.log)["HandPose"]
    return poses.raw("t_us"), poses.raw("valid") == 1


@pytest.mark.parametrize(
    "arguments",
    ["--dropout 0.1", "--gap 4:0.333", "--gap 5:0.2 --dropout 0.03", "--gap 9:100", "--gap 0:1"],
)
def test_lost_samples_match_the_bus(tmp_path, arguments):
    done = run(tmp_path / "out", "--scenario", "teleop", *arguments.split())
    stamp_us, valid = poses_of(done)
    seen_us = np.concatenate([stamp_us[:1], stamp_us[valid], stamp_us[-1:]])  # so that gaps at either end count
    tracker = done.summary["tracker"]
    assert tracker["samples"] == len(stamp_us)
    assert tracker["lost"] == np.sum(~valid) > 0
    assert tracker["longest_gap_ms"] == pytest.approx(1e-3 * np.diff(seen_us).max())


def test_gap_is_at_the_requested_time(tmp_path):
    done = run(tmp_path / "out", "--scenario", "teleop", "--gap", "4:0.333").require_pass()
    stamp_us, valid = poses_of(done)
    in_gap = (stamp_us >= 4_000_000) & (stamp_us < 4_333_000)
    assert np.array_equal(valid, ~in_gap)
    *_, held, returned, stopped = modes(done)
    assert (held, returned) == (("hold", "tracker_stale"), ("cooperating", "tracker_returned"))
    assert stopped == ("ready", "operator_stop")


def test_dropout_is_a_probability(tmp_path):
    """The share of lost samples is within five standard deviations of the probability, and each seed loses different
    samples."""
    drawn = [poses_of(run(tmp_path / str(seed), "--dropout", 0.1, "--seed", seed))[1] for seed in (1, 2)]
    for valid in drawn:
        assert np.mean(~valid) == pytest.approx(0.1, abs=5 * np.sqrt(0.1 * 0.9 / len(valid)))
    assert not np.array_equal(*drawn)


def hand_of(done: Run) -> np.ndarray:
    """Returns ODE's pose of the end effector, (ticks, 7)."""
    names = done.trace.open().readline().rstrip().split(",")
    columns = [names.index(f"hand_{part}") for part in ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")]
    return np.loadtxt(done.trace, delimiter=",", skiprows=1, usecols=columns)


SILENT = ("--noise-mm", 0, "--noise-deg", 0)
PLACES = [
    ("0.3,1.5,0.2", "0.70710678,0.70710678,0,0", (-np.pi / 2, 0, 0)),  # the default, equation (9)
    ("-2,0.5,-1", "0.70710678,0.70710678,0,0", (-np.pi / 2, 0, 0)),
    ("1.5,0,0.4", "1,0,0,0", (0, 0, 0)),
    ("2,1,1", f"{np.cos(0.35)},0,0,{np.sin(0.35)}", (0, 0, -0.7)),  # 0.7 rad about z
]


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_motion_does_not_depend_on_the_trackers_position(tmp_path, scenario):
    hands, markers = [], []
    for i, (translation, rotation, tracker_rotation) in enumerate(PLACES):
        turns = zip("xyz", tracker_rotation, strict=True)
        turned = [f"--param=tracker_rotation_{axis}_rad={angle:.6f}" for axis, angle in turns]
        mount = ("--mount-translation", translation, "--mount-rotation", rotation)
        done = run(tmp_path / str(i), "--scenario", scenario, *SILENT, *mount, *turned).require_pass()
        hands.append(hand_of(done))
        w, x, y, z = map(float, rotation.split(","))
        seen_m = bus_log.read(done.log)["HandPose"]
        seen_m = np.stack([seen_m[f"{axis}_m"] for axis in "xyz"], axis=1)
        markers.append(Rotation.from_quat([x, y, z, w]).apply(seen_m) + np.array(translation.split(","), float))
    for marker in markers[1:]:
        assert np.abs(marker - markers[0]).max() < 5e-6, "the tracker is not at its configured pose"
    assert np.ptp(hands[0][:, :3], axis=0).max() > 0.02, "the arm must have moved"
    for hand in hands[1:]:
        assert np.linalg.norm(hand[:, :3] - hands[0][:, :3], axis=1).max() < 1e-4
        assert np.abs(np.sum(hand[:, 3:] * hands[0][:, 3:], axis=1)).min() > np.cos(0.5 * np.radians(0.1))


# Prediction is off in these runs, because it would compensate for the latency.
def test_latency_delays_the_motion_and_nothing_else(tmp_path):
    early, late = (
        hand_of(run(tmp_path / str(ms), "--scenario", "teleop", *SILENT, "--param", "prediction=0", "--latency-ms", ms))
        for ms in (4, 24)
    )
    moving = slice(1900, 11400)  # from just after the start command to the stop
    shifted = late[20:][moving, :3] - early[:-20][moving, :3]
    assert np.linalg.norm(shifted, axis=1).max() < 1e-4
    assert np.linalg.norm(late[moving, :3] - early[moving, :3], axis=1).max() > 5e-4


def test_options_reach_the_bus(tmp_path):
    tracker = ("--rate", 100, "--tracker-clock", 4_294_000_000)
    done = run(tmp_path / "out", "--scenario", "pour", *SILENT, *tracker, "--scale", 0.5, "--duration", 6)
    log = bus_log.read(done.log)
    assert done.summary["sim_s"] == 6
    assert np.all(log["TrackerStatus"]["period_us"] == 10_000)
    stamp_us = log["HandPose"].raw("t_us")
    assert stamp_us[0] == 4_294_000_000
    assert np.all(np.diff(stamp_us) % 2**32 == 10_000) and np.any(np.diff(stamp_us) < 0), "wraps"
    access = log["ParameterAccess"]
    names = access.message.get_signal_by_name("parameter").choices
    assert [str(names[i]) for i in access.raw("parameter")] == ["motion_scale"]
    assert value_of(access) == [0.5]


def test_defined_task_reaches_the_firmware(tmp_path):
    task = "mirrored:0.01,-0.02,0.03:1,0,0,0:0.6,0,0,0.8:2.5"
    done = run(tmp_path / "out", "--scenario", "teleop", "--duration", 4, "--define", task)
    log = bus_log.read(done.log)
    define = log["TaskDefine"]
    sent = {name: define[name][0] for name in ("form", "t_task_x_m", "t_task_y_m", "t_task_z_m", "blend_s")}
    assert sent == pytest.approx(
        {"form": 1, "t_task_x_m": 0.01, "t_task_y_m": -0.02, "t_task_z_m": 0.03, "blend_s": 2.5}, abs=1e-6
    )
    assert [define[f"q_inv_{part}"][0] for part in "wxyz"] == pytest.approx([0.6, 0, 0, 0.8], abs=1e-4)
    acks = log["CommandAck"]
    names = acks.message.get_signal_by_name("command").choices
    assert [str(names[command]) for command in acks.raw("command")] == ["define", "start", "stop"]
    assert not acks.raw("result").any(), "all accepted"


def test_paper_law_is_sent_to_the_firmware(tmp_path):
    """The paper's law (4) has no weights, one gain, and the error in the torso frame. --param overrides these
    values."""
    done = run(tmp_path / "out", "--scenario", "pour", "--duration", 4, "--paper-law", "--param", "gain_w_per_s=3")
    access = bus_log.read(done.log)["ParameterAccess"]
    names = access.message.get_signal_by_name("parameter").choices
    written = {str(names[i]): value for i, value in zip(access.raw("parameter"), value_of(access), strict=True)}
    parts = [part + axis for part in ("", "dual_") for axis in "wxyz"]
    expected = {f"weight_{part}": 1 for part in parts} | {f"gain_{part}_per_s": 4 for part in parts}
    assert written == expected | {"prediction": 0, "error_frame": 0, "gain_w_per_s": 3}


def value_of(access: bus_log.Frames) -> np.ndarray:
    """Returns the float32 value of each ParameterAccess."""
    return access.data[:, 6:10].copy().view("<f4")[:, 0]


def test_axes_turn_the_motion(tmp_path):
    """A recorded motion along x moves the hand along the torso's x axis, or along the torso's y axis with the option
    --axes=-yxz."""
    recording = tmp_path / "hand.csv"
    path_m = 0.03 * np.sin(np.linspace(0, np.pi / 2, 200)) ** 2
    recording.write_text(recording_csv(*(f"{0.01 * i:.2f},{x:.6f},0,0,1,0,0,0" for i, x in enumerate(path_m))))
    ways = []
    for axes in ("xyz", "-yxz"):
        played = ("--scenario", "teleop", "--tracker", recording, "--axes", axes)
        hand = hand_of(run(tmp_path / axes, *played, *SILENT).require_pass())
        ways.append(hand[4200, :3] - hand[600, :3])
    assert ways[0] == pytest.approx([0.03, 0, 0], abs=2e-3)
    assert ways[1] == pytest.approx([0, 0.03, 0], abs=2e-3)
