"""Checks the latency in summary.json: it agrees with the latency that numpy computes from the trace, and changes with
the latency and rate of the tracker. The delay fit that measures this latency finds known delays."""

from __future__ import annotations

import monitor_binding
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from simulation import SCENARIOS, call, recording_csv, run

ffi, lib = monitor_binding.load()
PARAMETERS = [ffi.string(lib.parameter_table[i].name).decode() for i in range(lib.PARAMETER_COUNT)]
FORMER_LAW = ["--param", "prediction=0"] if "prediction" in PARAMETERS else []
PARTS = ("tracker_ms", "bus_ms", "estimate_ms", "law_ms", "command_bus_ms", "drive_ms")
LAGS_MS = np.arange(-20, 301, 2)  # the grid of sim/monitors/delay_fit.h


def latency(tmp_path, *arguments, scenario="teleop") -> dict:
    return run(tmp_path / "out", "--scenario", scenario, "--seed", 3, *FORMER_LAW, *arguments).summary["latency"]


def delay_of_trace_ms(file) -> float:
    """Returns the delay by which the person's path must be shifted so that its difference from the robot's path varies
    least. Valid only for `teleop`, in which the robot's path is a copy of the hand's path."""
    trace = np.genfromtxt(file, delimiter=",", names=True, dtype=None, encoding=None)
    person, hand = (np.array([trace[f"{who}_{axis}_m"] for axis in "xyz"]) for who in ("person", "hand"))
    speed = np.linalg.norm(np.gradient(person, axis=1), axis=0) * 1e3
    at = np.flatnonzero((trace["mode"] == "cooperating") & (speed > 0.01))
    at = at[at > 2000]
    delays = np.arange(0, 120)
    left = [np.var(hand[:, at] - person[:, at - d], axis=1).sum() for d in delays]
    best = int(np.argmin(left))
    bend = np.polyfit(delays[best - 2 : best + 3], left[best - 2 : best + 3], 2)
    return -bend[1] / (2 * bend[0])


def test_end_to_end_latency_matches_numpy_on_the_trace(tmp_path):
    measured = latency(tmp_path)
    assert measured["end_to_end_ms"] == pytest.approx(delay_of_trace_ms(tmp_path / "out" / "trace.csv"), abs=2)
    assert sum(measured[part] for part in PARTS) == pytest.approx(measured["end_to_end_ms"], abs=1e-3)
    assert measured["not_measured"] is None
    assert measured["how"] == {
        "tracker_ms": "announced", "bus_ms": "measured", "estimate_ms": "measured", "law_ms": "computed",
        "command_bus_ms": "measured", "drive_ms": "assumed", "end_to_end_ms": "measured",
    }  # fmt: skip


def test_one_law_has_equal_latency_in_every_task(tmp_path):
    """The tasks differ in the lever arm between the hands and in how the hand's motion is rotated or mirrored. These
    add no delay, so a given control law has the same latency in every task."""
    found = [latency(tmp_path / name, scenario=name)["end_to_end_ms"] for name in SCENARIOS]
    assert max(found) - min(found) < 6, found


def test_a_later_and_a_slower_tracker_add_their_delay(tmp_path):
    """With the former law, which does not predict, 20 ms more tracker latency adds 20 ms to the total, and
    interpolation adds one period of the tracker."""
    normal = latency(tmp_path / "a")
    late = latency(tmp_path / "b", "--latency-ms", 24)
    assert late["tracker_ms"] - normal["tracker_ms"] == pytest.approx(20)
    assert late["end_to_end_ms"] - normal["end_to_end_ms"] == pytest.approx(20, abs=1)
    assert late["estimate_ms"] == pytest.approx(normal["estimate_ms"], abs=1)
    slow = latency(tmp_path / "c", "--rate", 50)
    assert slow["estimate_ms"] - normal["estimate_ms"] == pytest.approx(20 - 4, abs=1.5)
    assert slow["law_ms"] == pytest.approx(normal["law_ms"], abs=1.5)


def test_classic_can_is_measured_too(tmp_path):
    measured = latency(tmp_path, "--profile", "classic")
    assert measured["bus_ms"] > 2 * latency(tmp_path / "fd")["bus_ms"] > 0
    assert measured["end_to_end_ms"] == pytest.approx(delay_of_trace_ms(tmp_path / "out" / "trace.csv"), abs=4)


def test_the_trackers_clock_does_not_matter(tmp_path):
    measured, other = latency(tmp_path / "a"), latency(tmp_path / "b", "--tracker-clock", 4294000000)
    assert other["bus_ms"] == pytest.approx(measured["bus_ms"], abs=1e-3)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], ["the arm could follow ", "of the hand's motion, and 1 s are needed"]),
        (["--param", "trace=0"], ["the trace is switched off"]),
    ],
    ids=["still", "no trace"],
)
def test_an_unmeasurable_latency_is_null_with_a_reason(tmp_path, arguments, words):
    recording = tmp_path / "hand.csv"
    recording.write_text(recording_csv(*(f"{0.01 * i:.2f},0,0,0,1,0,0,0" for i in range(300))))
    options = ["--scenario", "teleop", "--tracker", recording, *arguments]
    measured = run(tmp_path / "out", *options).summary["latency"]
    assert measured["end_to_end_ms"] is None and measured["estimate_ms"] is None and measured["law_ms"] is None
    assert measured["how"]["end_to_end_ms"] == "not measured"
    assert measured["tracker_ms"] == 4
    (line,) = (
        line for line in call(*options, "--out", tmp_path / "b").stdout.splitlines() if line.startswith("latency [ms]")
    )
    for word in words:
        assert word in measured["not_measured"] and word in line


# ---- the fit


@pytest.mark.parametrize("delay_ms", [-7.3, 0.0, 37.6, 180.2])
def test_a_known_delay_is_found(rng, delay_ms):
    """The fit finds the delay of a robot that follows a moving and turning hand, with an offset, a lever arm and 0.2 mm
    of noise. The robot follows in two separate intervals, with a different offset and lever arm in each."""

    def hand(t_s):
        """Returns positions (N, 3) and rotations (N, 3, 3) at the given times."""
        position_m = 0.05 * np.stack([np.sin(3 * t_s), np.sin(4 * t_s + 1), np.sin(5 * t_s + 2)], axis=-1)
        turns = np.stack([0.3 * np.sin(2 * t_s), 0.2 * np.cos(3 * t_s), np.full_like(t_s, 0.1)], axis=-1)
        return position_m, Rotation.from_rotvec(turns).as_matrix()

    fit = ffi.new("delay_fit_t *")
    past = ffi.new("delay_hand_t[]", len(LAGS_MS))
    seen = np.frombuffer(ffi.buffer(past), [("way_m", float, 3), ("turn", float, (3, 3))])
    of_lag = [ffi.addressof(past, n) for n in range(len(LAGS_MS))]
    for offset_m, lever_m in (
        (np.array([0.3, 0.1, 0]), np.array([0.1, 0, 0])),
        (np.zeros(3), np.array([0, -0.05, 0.02])),
    ):
        for t_s in np.arange(0, 3, 0.01):
            position_m, turn = (part[0] for part in hand(np.array([t_s - 1e-3 * delay_ms])))
            at_m = position_m + turn @ lever_m + offset_m + rng.normal(0, 2e-4, 3)
            seen["way_m"], seen["turn"] = hand(t_s - 1e-3 * LAGS_MS)
            follower = ffi.new("double[2][3]", [at_m.tolist()] * 2)
            lib.delay_fit_add(fit, follower, of_lag)
        lib.delay_fit_end_stretch(fit)
    assert lib.delay_fit_ms(fit, lib.DELAY_OF_ROBOT) == pytest.approx(delay_ms, abs=0.5)


def test_a_delay_beyond_the_grid_is_not_guessed():
    fit = ffi.new("delay_fit_t *")
    assert np.isnan(lib.delay_fit_ms(fit, lib.DELAY_OF_TARGET))
