"""Checks `comanip calibrate`: the tracker's rotation, computed from three moves of the hand, against scipy's
align_vectors, and the estimated error against the actual errors."""

from __future__ import annotations

import re
import threading
import time

import can
import numpy as np
import pytest
from bus_log import DBC
from can.interfaces.virtual import channels
from comanip.bus import logs
from comanip.bus.frame import Frame, protected
from comanip.tracker import calibration
from comanip.tracker.calibration import (
    CalibrationError,
    Move,
    MoveDetector,
    rotation_from_vector,
    rotation_vector,
    solve,
)
from comanip_command import call, call_here, require_refusal
from hub import wait_until
from hypothesis import given
from hypothesis import strategies as st
from live_firmware import CHANNEL, firmware
from scipy.spatial.transform import Rotation

RATE_HZ = 100
PAPER = Rotation.from_rotvec([-np.pi / 2, 0, 0])  # equation (9) of the paper
AXES = np.eye(3)


def path(
    rng, turn: Rotation, directions=AXES, length_m=0.25, noise_m=0.0005, bow_m=0.0
) -> list[tuple[float, np.ndarray]]:
    """Returns the path of a person's hand in the tracker's frame, with three moves between four rests."""
    samples, here, t_s = [], np.array([0.3, 0.1, 0.9]), 0.0
    for direction in [None, *directions]:
        if direction is not None:
            direction = np.array(direction, float) / np.linalg.norm(direction)
            aside = np.cross(direction, [0.3, 0.5, 0.8])
            for s in np.linspace(0, 1, RATE_HZ):
                blend = 10 * s**3 - 15 * s**4 + 6 * s**5
                samples.append((t_s, here + length_m * blend * direction + bow_m * np.sin(np.pi * blend) * aside))
                t_s += 1 / RATE_HZ
            here = here + length_m * direction
        for _ in range(RATE_HZ):
            samples.append((t_s, here))
            t_s += 1 / RATE_HZ
    return [(t, turn.apply(point) + rng.normal(0, noise_m, 3)) for t, point in samples]


def detected(samples) -> list[Move]:
    detector = MoveDetector()
    return [move for move in (detector.feed(t, point) for t, point in samples) if move]


def moves_along(directions) -> list[Move]:
    return [Move(np.array(d, float) / np.linalg.norm(d), 0.25, 0.0) for d in directions]


def random_tilts(rng, turn: Rotation, sigma_rad: float) -> np.ndarray:
    """Returns the three axes rotated by `turn`, each slightly tilted."""
    return np.array([Rotation.from_rotvec(rng.normal(0, sigma_rad, 3)).apply(turn.apply(axis)) for axis in AXES])


# ---- the rotation


def test_result_is_the_least_squares_rotation(rng):
    for turn in Rotation.random(50, random_state=3):
        directions = random_tilts(rng, turn, 0.05)
        expected, _ = Rotation.align_vectors(directions, AXES)
        assert np.abs(solve(moves_along(directions)).rotation - expected.as_matrix()).max() < 1e-9


@given(st.lists(st.floats(-1.8, 1.8), min_size=3, max_size=3))
def test_rotation_vectors_match_scipy(vector):
    turn = Rotation.from_rotvec(vector)
    assert np.abs(rotation_from_vector(turn.as_rotvec()) - turn.as_matrix()).max() < 1e-9
    assert (Rotation.from_rotvec(rotation_vector(turn.as_matrix())) * turn.inv()).magnitude() < 1e-6


@pytest.mark.parametrize("axis", [[1, 0, 0], [0, -1, 0], [0.6, 0.8, 0], [0.48, 0.6, -0.64]])
@pytest.mark.parametrize("less", [0, 1e-9, 1e-6, 1e-3])
def test_half_a_turn(axis, less):
    turn = Rotation.from_rotvec((np.pi - less) * np.array(axis))
    found = rotation_vector(turn.as_matrix())
    assert np.linalg.norm(found) <= np.pi + 1e-12, "the vector is within the parameters' range"
    assert (Rotation.from_rotvec(found) * turn.inv()).magnitude() < 1e-6


def test_reported_standard_error_matches_the_actual_errors(rng):
    """Over many calibrations with orthogonal moves, which determine all three axes equally well, the reported standard
    error matches the RMS of the actual errors."""
    sigma_rad = np.radians(2)
    reported, actual = [], []
    for turn in Rotation.random(600, random_state=5):
        result = solve(moves_along(random_tilts(rng, turn, sigma_rad)))
        reported.append(result.standard_error_deg**2)
        error = (Rotation.from_matrix(result.rotation) * turn.inv()).as_rotvec()
        actual.append(np.degrees(error) ** 2)
    assert np.sqrt(np.mean(reported)) == pytest.approx(np.sqrt(np.mean(actual)), rel=0.15)


# ---- the moves


def test_moves_are_found_between_rests(rng):
    for turn in (PAPER, *Rotation.random(5, random_state=11)):
        moves = detected(path(rng, turn))
        assert len(moves) == 3
        for move, axis in zip(moves, AXES):
            assert np.degrees(np.arccos(min(1, move.direction @ turn.apply(axis)))) < 1
            assert move.length_m == pytest.approx(0.25, abs=0.005)
        assert (Rotation.from_matrix(solve(moves).rotation) * turn.inv()).magnitude() < np.radians(1)


def test_a_hand_that_trembles_at_rest_makes_no_move(rng):
    assert detected([(0.01 * i, rng.normal(0, 0.001, 3)) for i in range(1000)]) == []


def test_a_short_move_does_not_count(rng):
    assert len(detected(path(rng, PAPER, length_m=0.08))) < 3


@pytest.mark.parametrize(
    ("directions", "bow_m", "words"),
    [
        ([[1, 0, 0], [0, -1, 0], [0, 0, 1]], 0, "left-handed"),
        ([[1, 0, 0], [1, 1, 0], [0, 0, 1]], 0, "too uncertain"),
        ([[1, 0, 0], [0, 1, 0], [0.5, 0.5, 0.7]], 0, "too uncertain"),
        (AXES, 0.12, "crooked"),
        (AXES[:2], 0, "2 moves found, expected 3"),
        ([*AXES, [-1, 0, 0]], 0, "4 moves found, expected 3"),
    ],
)
def test_refuses_moves_that_do_not_define_a_rotation(rng, directions, bow_m, words):
    with pytest.raises(CalibrationError, match=words):
        solve(detected(path(rng, PAPER, directions, bow_m=bow_m)))


# ---- the command


def write_recording(file, samples) -> None:
    lines = ["t_s,x_m,y_m,z_m,qw,qx,qy,qz", *(f"{t:.4f},{x:.6f},{y:.6f},{z:.6f},1,0,0,0" for t, (x, y, z) in samples)]
    file.write_text("\n".join(lines) + "\n")


def told_vector(text: str) -> np.ndarray:
    return np.array([float(word) for word in re.search(r"rotation vector (\S+) (\S+) (\S+) rad", text).groups()])


def hand_frames(samples, start_us=0) -> list[tuple[float, bytes]]:
    return [
        (
            t,
            protected(
                "HandPose",
                {
                    "t_us": (start_us + round(1e6 * t)) % 2**32,
                    "valid": 1,
                    "x_m": x,
                    "y_m": y,
                    "z_m": z,
                    "qw": 1,
                    "qx": 0,
                    "qy": 0,
                    "qz": 0,
                },
                i,
            ),
        )
        for i, (t, (x, y, z)) in enumerate(samples)
    ]


def test_from_a_recording_and_from_a_log(tmp_path, rng):
    turn = Rotation.from_rotvec([0.4, -1.1, 0.6])
    samples = path(rng, turn)
    write_recording(tmp_path / "moves.csv", samples)
    frame_id = DBC.get_message_by_name("HandPose").frame_id
    wrapping = hand_frames(samples, start_us=2**32 - 2_000_000)
    (tmp_path / "bus.log").write_text(
        "".join(logs.candump_line(Frame(round(1e6 * t), frame_id, data)) + "\n" for t, data in wrapping)
    )
    for name in ("moves.csv", "bus.log"):
        done = call("calibrate", "--from", tmp_path / name)
        assert done.returncode == 0, done.stderr
        assert (Rotation.from_rotvec(told_vector(done.stdout)) * turn.inv()).magnitude() < np.radians(1)
        commands = re.findall(r"^comanip param set (tracker_rotation_[xyz]_rad) -- (\S+)$", done.stdout, re.MULTILINE)
        assert [name for name, _ in commands] == [f"tracker_rotation_{axis}_rad" for axis in "xyz"]
        assert [float(value) for _, value in commands] == pytest.approx(told_vector(done.stdout), abs=1e-4)
        assert float(re.search(r"standard error (\S+) degrees", done.stdout)[1]) < 1


def test_bad_recordings(tmp_path):
    (tmp_path / "bad.csv").write_text("0,1,2,3,1,0,0,0\n0.1,1,2,x,1,0,0,0\n")
    require_refusal(call("calibrate", "--from", tmp_path / "bad.csv"), "bad.csv:2", "'x' is not a number")
    (tmp_path / "untimed.csv").write_text("1,2,3,1,0,0,0\n")
    require_refusal(call("calibrate", "--from", tmp_path / "untimed.csv"), "untimed.csv:1", "timestamp")
    (tmp_path / "rest.csv").write_text("".join(f"{0.01 * i},1,2,3,1,0,0,0\n" for i in range(300)))
    require_refusal(call("calibrate", "--from", tmp_path / "rest.csv"), "0 moves found")
    require_refusal(call("calibrate", "--from", tmp_path / "none.csv"), "none.csv")


def test_guides_a_person_and_sets_the_parameters(monkeypatch, capsys, rng):
    """`comanip calibrate` prompts a person for each move. In this test, a thread plays a generated path instead."""
    turn = Rotation.from_rotvec([-1.5, 0.2, -0.1])
    samples = path(rng, turn)
    with firmware(has_tracker=False) as live, can.Bus(interface="virtual", channel=CHANNEL, fd=True) as tracker:
        over = threading.Event()

        def play() -> None:
            wait_until(lambda: len(channels[CHANNEL]) == 3, "the command to listen")
            for _, data in hand_frames(samples):
                if over.is_set():
                    return
                tracker.send(can.Message(arbitration_id=0x120, data=data, is_extended_id=False, is_fd=True))
                time.sleep(0.002)

        player = threading.Thread(target=play)
        player.start()
        status, out, err = call_here(monkeypatch, capsys, "calibrate", "--set", "-i", "virtual", "-c", CHANNEL)
        over.set()
        player.join()
        assert status == 0, err
        first = live.bench.controller.parameters.value
        found = Rotation.from_rotvec([first[19 + i] for i in range(3)])
    assert (found * turn.inv()).magnitude() < np.radians(1)
    for prompt in ("Hold the marked hand still", "1/3", "forward", "2/3", "left", "3/3", "up", "written"):
        assert prompt in out


def test_parameters_are_those_of_the_core():
    values = [calibration.PARAMETERS[i] for i in range(3)]
    names = DBC.get_message_by_name("ParameterValue").get_signal_by_name("parameter").choices
    assert values == [str(names[19 + i]) for i in range(3)]
