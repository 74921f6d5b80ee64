"""`comanip tracker --stdin` turns lines of text into protected frames with poses, as scipy, cantools, autosar-e2e and
the C core confirm."""

from __future__ import annotations

import io
import json
import sys

import can
import numpy as np
import pytest
from bus_log import DBC
from comanip._core import lib
from comanip.tracker import pose_lines
from comanip_command import WRONG_USE, call, call_here, require_refusal
from e2e import p05
from hub import wait_until
from hypothesis import given
from hypothesis import strategies as st
from live_firmware import CHANNEL, firmware
from scipy.spatial.transform import Rotation

POSITION = [0.4, -0.25, 1.125]
TURN = Rotation.from_rotvec([0.3, -1.2, 0.7])
XYZW = TURN.as_quat()
WXYZ = [XYZW[3], *XYZW[:3]]
MATRIX = np.hstack([TURN.as_matrix(), np.array([POSITION]).T])


def csv(*numbers: float, separator: str = ",") -> str:
    return separator.join(repr(float(number)) for number in numbers)


# ---- lines

GOOD = {
    "quaternion": csv(*POSITION, *WXYZ),
    "time and quaternion": csv(12.5, *POSITION, *WXYZ),
    "blanks": csv(*POSITION, *WXYZ, separator="  "),
    "semicolons": csv(*POSITION, *WXYZ, separator=" ; "),
    "3x4": csv(*MATRIX.ravel()),
    "time and 3x4": csv(12.5, *MATRIX.ravel()),
    "4x4": csv(*MATRIX.ravel(), 0, 0, 0, 1),
    "time and 4x4": csv(12.5, *MATRIX.ravel(), 0, 0, 0, 1),
    "json": json.dumps({"position": POSITION, "quaternion": WXYZ}),
    "json with time": json.dumps({"t": 12.5, "position": POSITION, "quaternion": WXYZ}),
    "json matrix": json.dumps({"matrix": MATRIX.tolist()}),
    "json 4x4": json.dumps({"t": 12.5, "matrix": [*MATRIX.ravel().tolist(), 0, 0, 0, 1]}),
    "-q": csv(*POSITION, *(-np.array(WXYZ))),
}


@pytest.mark.parametrize("kind", GOOD)
def test_good_lines(kind):
    pose = pose_lines.parse(GOOD[kind] + "\r\n")
    assert pose.t_s == (12.5 if "time" in kind or kind == "json 4x4" else None)
    assert pose.position_m == pytest.approx(POSITION)
    w, x, y, z = pose.quaternion
    assert (Rotation.from_quat([x, y, z, w]) * TURN.inv()).magnitude() < 1e-9


def test_order_xyzw():
    pose = pose_lines.parse(csv(*POSITION, *XYZW), "xyzw")
    assert pose.quaternion == pytest.approx(WXYZ)


@given(st.lists(st.floats(-3.2, 3.2), min_size=3, max_size=3))
def test_any_matrix_gives_its_quaternion(vector):
    turn = Rotation.from_rotvec(vector)
    line = csv(*np.hstack([turn.as_matrix(), np.zeros((3, 1))]).ravel())
    w, x, y, z = pose_lines.parse(line).quaternion
    assert (Rotation.from_quat([x, y, z, w]) * turn.inv()).magnitude() < 1e-7


@pytest.mark.parametrize("line", ["", "   ", "# note", "t_s,x_m,y_m,z_m,qw,qx,qy,qz"])
def test_lines_without_a_pose(line):
    assert pose_lines.parse(line) is None


BAD = {
    "1,2,3": "3 numbers, expected 7",
    csv(*POSITION, 1, 1, 0, 0): "norm 1.41421, expected 1",
    csv(*POSITION, *WXYZ[:3], float("nan")): "'nan' is not finite",
    "0,0,zero,1,0,0,0": "'zero' is not a number",
    csv(*(2 * MATRIX).ravel()): "not a rotation matrix",
    csv(*np.hstack([np.diag([1.0, 1, -1]), np.zeros((3, 1))]).ravel()): "a reflection",
    csv(*MATRIX.ravel(), 1, 0, 0, 1): "expected 0 0 0 1",
    "nan,nan,nan,nan,nan,nan,nan": "'nan' is not finite",
    "hello, world": "'hello' is not a number",
    "{": "not valid JSON",
    '{"position": [1,2,3]}': "'quaternion' is missing",
    '{"position": [1,2], "quaternion": [1,0,0,0]}': "position of 2 numbers, expected 3",
    '{"position": [1,2,"x"], "quaternion": [1,0,0,0]}': "'x', expected finite numbers",
    '{"position": [1,2,true], "quaternion": [1,0,0,0]}': "expected finite numbers",
    '{"position": [1,2,NaN], "quaternion": [1,0,0,0]}': "expected finite numbers",
    '{"matrix": [1,2,3]}': "matrix of 3 numbers, expected 3 x 4",
    '{"pose": 1}': "unknown 'pose'",
    '{"t": "now", "matrix": []}': "'now', expected finite numbers",
}


@pytest.mark.parametrize("line", BAD)
def test_bad_lines_are_explained(line):
    with pytest.raises(ValueError) as error:
        pose_lines.parse(line)
    assert BAD[line] in str(error.value)
    assert "\n" not in str(error.value)


@given(st.text(max_size=60) | st.text('0123456789.,-e {}[]":tpositonquaermx', max_size=80))
def test_any_line_is_a_pose_or_nothing_or_a_value_error(line):
    try:
        pose = pose_lines.parse(line)
    except ValueError:
        return
    assert pose is None or abs(np.linalg.norm(pose.quaternion) - 1) < 1e-9


# ---- on the bus


def publish(monkeypatch, capsys, lines: list[str], *options: str) -> tuple[int, str, list[can.Message]]:
    """Returns exit status, standard error, and the messages on the bus."""
    monkeypatch.setattr(sys, "stdin", io.StringIO("".join(line + "\n" for line in lines)))
    with can.Bus(interface="virtual", channel="tracker-test", fd=True) as bus:
        status, out, err = call_here(
            monkeypatch, capsys, "tracker", "--stdin", "-i", "virtual", "-c", "tracker-test", *options
        )
        assert out == ""
        messages = []
        while (message := bus.recv(0)) is not None:
            messages.append(message)
    return status, err, messages


def signals(messages: list[can.Message], name: str) -> list[dict]:
    layout = DBC.get_message_by_name(name)
    found = [message for message in messages if message.arbitration_id == layout.frame_id]
    for before, message in zip([None, *found], found):
        assert p05.e2e_p05_check(bytes(message.data), layout.dbc.attributes["E2EDataId"].value)
        assert before is None or message.data[2] == (before.data[2] + 1) % 256
        assert message.is_fd and len(message.data) == layout.length
    return [layout.decode(bytes(message.data)) for message in found]


def test_each_pose_is_a_frame(monkeypatch, capsys, rng):
    turns = Rotation.random(200, random_state=7)
    points = rng.uniform(-3, 3, (200, 3))
    lines = [
        csv(4294.9 + 0.005 * i, *points[i], *np.roll(turns[i].as_quat(), 1)) for i in range(200)
    ]  # the 32-bit clock wraps within these times
    status, err, messages = publish(monkeypatch, capsys, lines)
    assert (status, err) == (0, "200 poses sent, 0 lost, 0 of them out of the signals' range\n")
    poses = signals(messages, "HandPose")
    assert [pose["t_us"] for pose in poses] == [round(1e6 * (4294.9 + 0.005 * i)) % 2**32 for i in range(200)]
    assert all(pose["valid"] == 1 for pose in poses)
    found = np.array([[pose[name] for name in ("x_m", "y_m", "z_m")] for pose in poses])
    assert np.abs(found - points).max() <= 0.5e-6 + 1e-12
    quaternions = np.array([[pose[name] for name in ("qw", "qx", "qy", "qz")] for pose in poses])
    assert np.abs(quaternions - np.roll(turns.as_quat(), 1, axis=1)).max() <= 0.5 * 2**-22 + 1e-12
    statuses = signals(messages, "TrackerStatus")
    assert statuses[-1]["period_us"] == 5000


def test_bad_lines_are_reported_and_sent_as_lost_samples(monkeypatch, capsys):
    lines = [csv(0.0, *POSITION, *WXYZ), "nonsense,1", csv(0.01, 9, 0, 0, *WXYZ), csv(0.02, *POSITION, *WXYZ)]
    status, err, messages = publish(monkeypatch, capsys, lines)
    assert status == 1
    assert err.splitlines() == [
        "comanip: line 2: 'nonsense' is not a number",
        "2 poses sent, 2 lost, 1 of them out of the signals' range",
    ]
    poses = signals(messages, "HandPose")
    assert [pose["valid"] for pose in poses] == [1, 0, 0, 1]
    assert all(pose[name] == 0 for pose in poses[1:3] for name in ("x_m", "qw"))
    last = signals(messages, "TrackerStatus")[-1]
    assert (last["lost_samples"], last["range_errors"]) == (2, 1)


def test_lines_without_times_are_stamped_on_arrival(monkeypatch, capsys):
    status, _, messages = publish(monkeypatch, capsys, 20 * [csv(*POSITION, *WXYZ)], "--rate", "100")
    assert status == 0
    stamps = [pose["t_us"] for pose in signals(messages, "HandPose")]
    assert all(0 <= (after - before) % 2**32 < 10**7 for before, after in zip(stamps, stamps[1:]))
    assert {message["period_us"] for message in signals(messages, "TrackerStatus")} <= {10_000}


def test_a_recording_at_its_own_pace(monkeypatch, capsys):
    import time

    began_s = time.monotonic()
    status, _, _ = publish(monkeypatch, capsys, [csv(5 + 0.1 * i, *POSITION, *WXYZ) for i in range(6)], "--pace")
    assert status == 0
    assert time.monotonic() - began_s >= 0.5


def test_the_core_accepts_the_poses(monkeypatch, capsys):
    with firmware(has_tracker=False) as live:
        lines = [csv(0.004 * i, *POSITION, *WXYZ) for i in range(400)]
        monkeypatch.setattr(sys, "stdin", io.StringIO("".join(line + "\n" for line in lines)))
        status, _, err = call_here(monkeypatch, capsys, "tracker", "--stdin", "--pace", "-i", "virtual", "-c", CHANNEL)
        assert status == 0, err
        wait_until(lambda: live.bench.controller.hand_tracker.last_stamp_us == 399 * 4000, "the last pose")
        assert live.bench.controller.hand_tracker.period_us == 4000
        assert live.bench.controller.receiver.protocol.rejected <= 2, "the first frame of each id may repeat a counter"
        assert live.bench.controller.receiver.protocol.e2e[lib.FRAME_HAND_POSE].started


def test_wrong_use():
    require_refusal(call("tracker"), "--stdin")
    require_refusal(call("tracker", "--stdin", "--quaternion", "zyxw", "-i", "virtual"), "zyxw", "wxyz")
    done = call("tracker", "--stdin", "--pace", "-i", "virtual", text=csv(*POSITION, *WXYZ) + "\n")
    require_refusal(done, "timestamp")
    assert done.returncode == WRONG_USE
