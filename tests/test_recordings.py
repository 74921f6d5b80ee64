"""Checks recorded hand motions: reading of the CSV file, resampling (against scipy), gaps, axes, and a clear one-line
message for each defect of a file."""

from __future__ import annotations

import itertools
import os

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp
from sim_binding import load

ffi, lib = load()

QUATERNION_HEADER = "t_s,x_m,y_m,z_m,qw,qx,qy,qz"
MATRIX_HEADER = "t_s,x_m,y_m,z_m,r11,r12,r13,r21,r22,r23,r31,r32,r33"
ROW = "{},0.1,0.2,0.3,1,0,0,0"


def open_recording(path, axes: str | None = None):
    """Returns the motion or the error message."""
    error = ffi.new("char[]", 400)
    axes_text = ffi.NULL if axes is None else ffi.new("char[]", axes.encode())
    motion = lib.recorded_motion_create(str(path).encode(), axes_text, error, 400)
    if motion == ffi.NULL:
        return ffi.string(error).decode()
    return ffi.gc(motion, lib.recorded_motion_destroy)


def sample(motion, times_s):
    """Returns validity, position and quaternion at each time."""
    pose = ffi.new("rigid_pose_t *")
    valid, position, quaternion = [], [], []
    for time_s in times_s:
        valid.append(lib.recorded_motion_sample(motion, time_s, pose))
        position.append(list(pose.position_m))
        quaternion.append(list(pose.rotation))
    return np.array(valid), np.array(position), np.array(quaternion)


def random_motion(rng, count=200, interval_s=0.01):
    times_s = 5 + interval_s * np.arange(count) + rng.uniform(-0.1, 0.1, count) * interval_s
    return times_s, rng.normal(size=(count, 3)), Rotation.random(count, rng=rng)


def write(path, times_s, positions_m, rotations: Rotation, matrix=False, sign=None):
    if matrix:
        columns = rotations.as_matrix().reshape(-1, 9)
    else:
        columns = rotations.as_quat(scalar_first=True) * (1 if sign is None else sign[:, None])
    header = MATRIX_HEADER if matrix else QUATERNION_HEADER
    np.savetxt(path, np.column_stack([times_s, positions_m, columns]), "%.17g", ",", header=header, comments="")
    return path


def write_text(path, *lines: str, end="\n"):
    path.write_bytes("".join(line + end for line in lines).encode())
    return path


# ---- resampling


@pytest.mark.parametrize("matrix", [False, True])
def test_resampling_is_linear_and_spherical(tmp_path, rng, matrix):
    times_s, positions_m, rotations = random_motion(rng)
    sign = rng.choice([-1.0, 1.0], len(times_s))  # a recorder may choose the sign freely
    motion = open_recording(write(tmp_path / "a.csv", times_s, positions_m, rotations, matrix, sign))
    assert lib.recorded_motion_duration_s(motion) == pytest.approx(times_s[-1] - times_s[0], abs=1e-12)

    at_s = np.sort(rng.uniform(times_s[0], times_s[-1], 3000))
    valid, position_m, quaternion = sample(motion, at_s - times_s[0])
    assert valid.all()
    expected_m = np.column_stack([np.interp(at_s, times_s, positions_m[:, i]) for i in range(3)])
    np.testing.assert_allclose(position_m, expected_m, atol=1e-11)
    difference = Rotation.from_quat(quaternion, scalar_first=True).inv() * Slerp(times_s, rotations)(at_s)
    assert difference.magnitude().max() < 1e-7
    np.testing.assert_allclose(np.linalg.norm(quaternion, axis=1), 1, atol=1e-12)


def test_signs_are_continuous(tmp_path, rng):
    times_s = np.arange(500) / 100
    rotations = Rotation.from_rotvec(np.outer(4 * times_s, [0.6, 0.0, 0.8]))  # more than one turn
    sign = rng.choice([-1.0, 1.0], 500)
    motion = open_recording(write(tmp_path / "a.csv", times_s, np.zeros((500, 3)), rotations, sign=sign))
    _, _, quaternion = sample(motion, np.arange(0, 5, 0.004))
    assert (quaternion[1:] * quaternion[:-1]).sum(axis=1).min() > 0.999


def test_first_and_last_pose_are_held(tmp_path, rng):
    times_s, positions_m, rotations = random_motion(rng)
    motion = open_recording(write(tmp_path / "a.csv", times_s, positions_m, rotations))
    valid, position_m, _ = sample(motion, [-1.0, 0.0, times_s[-1] - times_s[0], 1e6])
    assert valid.all()
    np.testing.assert_array_equal(position_m, positions_m[[0, 0, -1, -1]])


def test_gap_is_an_interval_above_one_and_a_half_medians(tmp_path):
    """Intervals longer than 1.5 times the median are gaps, in which no pose is valid. The samples at both ends of a gap
    are valid."""
    # The median interval is 10 ms, so the interval of 14 ms is not a gap, but the one of 16 ms is.
    times_s = np.array([0, 10, 20, 30, 44, 54, 70, 80, 90, 100]) / 1000
    still = Rotation.identity(len(times_s))
    motion = open_recording(write(tmp_path / "a.csv", times_s, times_s[:, None] * [1, 0, 0], still))
    at_s = np.arange(0, 101) / 1000
    valid, position_m, _ = sample(motion, at_s)
    assert at_s[~valid].tolist() == pytest.approx(np.arange(55, 70) / 1000)
    np.testing.assert_allclose(position_m[:, 0], at_s, atol=1e-12)  # interpolated between the samples
    assert b"gaps 1 (longest 16 ms)" in ffi.string(lib.recorded_motion_description(motion))


# ---- axes

AXES = [  # all 48 mappings of axes onto axes, half of them left-handed
    ("".join(("-" if s < 0 else "") + "xyz"[i] for i, s in zip(order, signs)), np.diag(signs) @ np.eye(3)[list(order)])
    for order in itertools.permutations(range(3))
    for signs in itertools.product([1, -1], repeat=3)
]


@pytest.mark.parametrize(("axes", "matrix"), AXES)
def test_axes_are_mapped_by_a_rotation_or_refused(tmp_path, rng, axes, matrix):
    times_s, positions_m, rotations = random_motion(rng, 5)
    motion = open_recording(write(tmp_path / "a.csv", times_s, positions_m, rotations), axes)
    if np.linalg.det(matrix) < 0:
        assert motion.startswith(f"axes '{axes}': expected ")
        return
    _, position_m, quaternion = sample(motion, times_s - times_s[0])
    np.testing.assert_allclose(position_m, positions_m @ matrix.T, atol=1e-12)
    difference = Rotation.from_quat(quaternion, scalar_first=True).inv() * (Rotation.from_matrix(matrix) * rotations)
    assert difference.magnitude().max() < 1e-7


@pytest.mark.parametrize("axes", ["", "xy", "xxz", "xyzx", "xyw", "XYZ", "--xyz", "x y z", "yxz", "-x-y-z"])
def test_invalid_axes_are_refused(tmp_path, axes):
    path = write_text(tmp_path / "a.csv", QUATERNION_HEADER, ROW.format(0), ROW.format(1))
    assert open_recording(path, axes).startswith(f"axes '{axes}': expected ")


@pytest.mark.parametrize(
    ("name", "expected_m"),
    [
        ("cmu_1.csv", [0.3, 0.1, 0.2]),
        ("ktk_glove.csv", [0.3, 0.1, 0.2]),
        ("kth_1.csv", [0.1, 0.2, 0.3]),
        ("my_cmu_.csv", [0.1, 0.2, 0.3]),
    ],
)
def test_default_axes_follow_the_name(tmp_path, name, expected_m):
    path = write_text(tmp_path / name, QUATERNION_HEADER, ROW.format(0), ROW.format(1))
    _, position_m, _ = sample(open_recording(path), [0.0])
    np.testing.assert_allclose(position_m, [expected_m], atol=1e-15)


# ---- accepted and refused files


def test_crlf_blank_end_and_unfinished_line_are_accepted(tmp_path):
    lines = [QUATERNION_HEADER, ROW.format(0), ROW.format(1), ROW.format("2.5")]
    for path in (
        write_text(tmp_path / "crlf.csv", *lines, end="\r\n"),
        write_text(tmp_path / "blank.csv", *lines, "", "  ", ""),
        write_text(tmp_path / "unfinished.csv", "\n".join(lines), end=""),
    ):
        assert lib.recorded_motion_duration_s(open_recording(path)) == 2.5


@pytest.mark.parametrize("header", [QUATERNION_HEADER, MATRIX_HEADER])
def test_byte_order_mark_is_accepted_in_front_of_the_header_only(tmp_path, header):
    row = ROW if header == QUATERNION_HEADER else "{},0,0,0,1,0,0,0,1,0,0,0,1"
    path = write_text(tmp_path / "spreadsheet.csv", "\ufeff" + header, row.format(0), row.format(1))
    assert path.read_bytes().startswith(b"\xef\xbb\xbf")
    assert lib.recorded_motion_duration_s(open_recording(path)) == 1


BAD_MATRIX = "{},0,0,0,1,0,0,0,1,0,0,0,{}"


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([], ": is empty, expected the header"),
        ([QUATERNION_HEADER], ": samples: 0, expected at least 2"),
        ([QUATERNION_HEADER, ROW.format(0)], ": samples: 1, expected at least 2"),
        ([ROW.format(0), ROW.format(1)], ":1: header is '0,0.1,0.2,0.3,1,0,0,0', expected t_s,x_m"),
        ([QUATERNION_HEADER + ",e", ROW.format(0)], ":1: header is "),
        (["\x1b[2J\x07"], ":1: header is '?[2J?', expected "),
        ([QUATERNION_HEADER, "7"], ":2: has 1 column, expected 8"),
        ([QUATERNION_HEADER, ROW.format(0), "1,2,3"], f":3: has 3 columns, expected 8: {QUATERNION_HEADER}"),
        ([QUATERNION_HEADER, ROW.format(0) + ",5"], ":2: has 9 columns, expected 8"),
        ([MATRIX_HEADER, ROW.format(0)], ":2: has 8 columns, expected 13"),
        ([QUATERNION_HEADER, "0,0.1,abc,0.3,1,0,0,0"], ":2: y_m is 'abc', expected a number"),
        ([QUATERNION_HEADER, "0,0.1,,0.3,1,0,0,0"], ":2: y_m is '', expected a number"),
        ([QUATERNION_HEADER, "0,0.1,0.2x,0.3,1,0,0,0"], ":2: y_m is '0.2x', expected a number"),
        ([QUATERNION_HEADER, "0,0.1,0x1p3,0.3,1,0,0,0"], ":2: y_m is '0x1p3', expected a number"),
        ([QUATERNION_HEADER, "0,0.1,1.5 2,0.3,1,0,0,0"], ":2: y_m is '1.5 2', expected a number"),
        ([QUATERNION_HEADER, "0,0.1,nan,0.3,1,0,0,0"], ":2: y_m is 'nan', expected a number"),
        ([QUATERNION_HEADER, "0,0.1,0.2,-inf,1,0,0,0"], ":2: z_m is '-inf', expected a number"),
        ([QUATERNION_HEADER, "0,0.1,0.2,0.3,1e999,0,0,0"], ":2: qw is 1e999, expected a finite number"),
        ([QUATERNION_HEADER, "0,2000,0.2,0.3,1,0,0,0"], ":2: x_m is 2000, expected within 1000 m"),
        (
            [QUATERNION_HEADER, ROW.format(1), ROW.format(2), ROW.format(1.5)],
            ":4: t_s is 1.5, expected more than the 2 before it",
        ),
        (
            [QUATERNION_HEADER, ROW.format(7.25), ROW.format(7.25)],
            ":3: t_s is 7.25, expected more than the 7.25 before it",
        ),
        ([QUATERNION_HEADER, ROW.format(0), ROW.format(1e5)], ":3: t_s is 100000, expected at most 86400 s after"),
        ([QUATERNION_HEADER, "0,0,0,0,1,0,0,0.1"], ":2: norm of qw,qx,qy,qz is 1.00499, expected 1 within 0.001"),
        ([QUATERNION_HEADER, "0,0,0,0,0,0,0,0"], ":2: norm of qw,qx,qy,qz is 0, expected 1 within 0.001"),
        (
            [MATRIX_HEADER, BAD_MATRIX.format(0, 1), BAD_MATRIX.format(1, 1.01)],
            ":3: r11..r33 is not a rotation: the product of columns 3 and 3 is 1.0201, expected 1 within 0.001",
        ),
        ([MATRIX_HEADER, BAD_MATRIX.format(0, -1)], ":2: r11..r33 is a reflection: determinant -1, expected 1"),
        ([QUATERNION_HEADER, ROW.format(0), "", ROW.format(1)], ":3: is empty but followed by samples"),
        ([QUATERNION_HEADER, ROW.format(0) + " " * 2000], ":2: is longer than 1022 characters or holds a zero byte"),
        (
            [QUATERNION_HEADER, ROW.format(0) + "\0", ROW.format(1)],
            ":2: is longer than 1022 characters or holds a zero",
        ),
    ],
)
def test_defects_are_named(tmp_path, lines, message):
    path = write_text(tmp_path / "hand.csv", *lines)
    error = open_recording(path)
    assert isinstance(error, str) and error.startswith(f"{path}{message}")
    assert error.isprintable(), "one line without control characters"


def test_unit_quaternion_within_tolerance_is_normalised(tmp_path):
    path = write_text(tmp_path / "a.csv", QUATERNION_HEADER, "0,0,0,0,1.0009,0,0,0", "1,0,0,0,0.9991,0,0,0")
    np.testing.assert_allclose(sample(open_recording(path), [0.0, 0.5, 1.0])[2], [[1, 0, 0, 0]] * 3, atol=1e-15)


def test_files_that_cannot_be_read(tmp_path):
    missing = tmp_path / "missing.csv"
    assert open_recording(missing) == f"{missing}: cannot be read: No such file or directory"
    assert open_recording(tmp_path) == f"{tmp_path}: is a directory, expected a CSV file"
    assert open_recording("/dev/zero") == "/dev/zero: is not a regular file, expected a CSV file"
    os.mkfifo(tmp_path / "pipe")
    assert open_recording(tmp_path / "pipe") == f"{tmp_path / 'pipe'}: is not a regular file, expected a CSV file"


# ---- playback from the hand's pose


def test_playback_repeats_the_recorded_motion(tmp_path, rng):
    """Playback may start from a different pose than the recording, and may be scaled. The hand in this recording makes
    slightly more than a full turn about a tilted axis, and is played at half the angle. A rotation vector computed from
    each pose alone would jump where the recorded angle passes pi."""
    times_s = np.arange(201) / 100
    positions_m = np.cumsum(rng.normal(scale=0.001, size=(201, 3)), axis=0)
    turns = Rotation.from_rotvec(np.outer(2.2 * np.pi * times_s / 2, [0.6, 0.0, 0.8])) * Rotation.random(rng=rng)
    sign = rng.choice([-1.0, 1.0], 201)
    motion = open_recording(write(tmp_path / "a.csv", times_s, positions_m, turns, sign=sign))
    here_m, here = np.array([0.3, -0.2, 0.1]), Rotation.random(rng=rng)

    playback = ffi.new("playback_t *")
    lib.playback_init(playback, motion, 0.2, 1.9, 0.25, 0.5)
    here_wxyz = here.as_quat(scalar_first=True).tolist()
    pose = ffi.new("rigid_pose_t *", {"position_m": here_m.tolist(), "rotation": here_wxyz})
    lib.playback_begin(playback, 7.0, pose)
    assert lib.playback_duration_s(playback) == pytest.approx(1.7)
    for since_s in (-1.0, 0.0, 0.33, 0.9, 1.3, 1.7, 5.0):
        assert lib.playback_sample(playback, 7.0 + since_s, pose)
        n = 20 + round(100 * np.clip(since_s, 0, 1.7))
        expected_m = here_m + 0.25 * (positions_m[n] - positions_m[20])
        np.testing.assert_allclose(list(pose.position_m), expected_m, atol=1e-12)
        angle = 0.5 * 2.2 * np.pi * (times_s[n] - times_s[20]) / 2
        expected = Rotation.from_rotvec(angle * np.array([0.6, 0.0, 0.8])) * here
        assert (Rotation.from_quat(list(pose.rotation), scalar_first=True).inv() * expected).magnitude() < 1e-7
