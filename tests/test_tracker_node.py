"""The simulated tracker on the bus: its frames are decoded with cantools and autosar-e2e, its poses compared with
scipy."""

from __future__ import annotations

import numpy as np
import pytest
from e2e import p05
from scipy.spatial.transform import Rotation
from scipy.stats import kstest
from sim_binding import load

ffi, lib = load()

HAND_POSE, TRACKER_STATUS = 0x120, 0x320
SECOND_NS = 10**9
TICK_NS = 10**6


def rotation(wxyz) -> Rotation:
    return Rotation.from_quat(np.asarray(wxyz, float), scalar_first=True)


def legs(*, displacement_m=(0.1, -0.2, 0.3), turn_rad=(0.5, -0.4, 0.9), start_s=0.5, start=(0.2, -0.1, 0.1)):
    """Returns a motion for play(): a function that sets `pose` to the hand's pose at the given time, during a move of 1
    s. It returns True, because the tracker always sees the hand."""
    path = ffi.new("hand_path_t *")
    turn = Rotation.from_rotvec(turn_rad).as_quat(scalar_first=True).tolist()
    first = ffi.new("rigid_pose_t *", {"position_m": start, "rotation": [1, 0, 0, 0]})
    last = ffi.new("rigid_pose_t *", {"position_m": np.add(start, displacement_m).tolist(), "rotation": turn})
    lib.hand_path_init(path, first, last, ffi.NULL, start_s, 1.0)

    def motion(time_s, pose):
        lib.hand_path_sample(path, time_s, pose)
        return True

    return motion


def options(**changes):
    result = ffi.new("tracker_options_t *")
    lib.tracker_options_set_defaults(result)
    for name, value in changes.items():
        setattr(result, name, value)
    return result


def quiet(**changes):
    return options(**{"noise_position_m": 0, "noise_rotation_rad": 0, **changes})


def play(dbc, motion, tracker_options, duration_s=2.0, step_ns=TICK_NS):
    """Returns poses, statuses and statistics of a run. Each frame is paired with the time in ns at which it ends on the
    bus. At the start of each tick, the tracker is given the hand's pose."""
    frames = []

    @ffi.callback("bus_handler_t")
    def receive(_context, frame, end_ns):
        frames.append((frame.id, end_ns, bytes(frame.data[0 : frame.length])))

    bus = ffi.gc(lib.bus_create(lib.CAN_PROFILE_FD), lib.bus_destroy)
    lib.bus_listen(bus, receive, ffi.NULL)
    history = ffi.gc(lib.hand_history_create(), lib.hand_history_destroy)
    tracker = ffi.gc(lib.tracker_node_create(bus, history, tracker_options), lib.tracker_node_destroy)
    pose = ffi.new("rigid_pose_t *")
    for now_ns in range(0, round(duration_s * SECOND_NS), step_ns):
        for tick_ns in range(now_ns, now_ns + step_ns, TICK_NS):
            visible = motion(tick_ns / SECOND_NS, pose)
            lib.hand_history_push(history, tick_ns, pose, visible)
        lib.tracker_node_step(tracker, now_ns, now_ns + step_ns)
        lib.bus_run_until(bus, now_ns + step_ns)
    lib.bus_run_until(bus, round(duration_s * SECOND_NS) + 1_000_000)
    messages = {HAND_POSE: [], TRACKER_STATUS: []}
    for identifier, end_ns, data in frames:
        data_id = dbc.get_message_by_frame_id(identifier).dbc.attributes["E2EDataId"].value
        assert p05.e2e_p05_check(data, data_id)
        messages[identifier].append((end_ns, dbc.decode_message(identifier, data, decode_choices=False)))
    return messages[HAND_POSE], messages[TRACKER_STATUS], lib.tracker_node_statistics(tracker)


def vectors(poses):
    position = np.array([[pose[f"{axis}_m"] for axis in "xyz"] for _, pose in poses])
    return position, np.array([[pose[f"q{axis}"] for axis in "wxyz"] for _, pose in poses])


def test_marker_is_measured_in_the_mounted_trackers_frame(dbc):
    mount_m, mount = np.array([1.0, -2.0, 0.5]), Rotation.from_rotvec([0.3, -1.1, 0.7])
    tracker_options = quiet(
        rate_hz=100,
        latency_s=0.007,
        mount_translation_m=list(mount_m),
        mount_rotation=list(mount.as_quat(scalar_first=True)),
    )
    poses, _, statistics = play(dbc, legs(start_s=0.25), tracker_options)
    position_m, quaternion = vectors(poses)

    t = np.arange(len(poses)) / 100
    x = np.clip(t - 0.25, 0, 1)[:, None]
    share = 10 * x**3 - 15 * x**4 + 6 * x**5
    hand_m = np.array([0.2, -0.1, 0.1]) + share * np.array([0.1, -0.2, 0.3])
    hand = Rotation.from_rotvec(share * np.array([0.5, -0.4, 0.9]))
    np.testing.assert_allclose(position_m, mount.inv().apply(hand_m - mount_m), atol=1e-6)
    assert np.max((rotation(quaternion).inv() * (mount.inv() * hand)).magnitude()) < 2e-6
    assert (statistics.samples, statistics.lost) == (len(poses), 0) == (200, 0)


def test_default_mount_is_the_papers(dbc):
    """The default mount is that of equation (9) of the paper, in which q_Tv^E = q(x, -pi/2) rotates the tracker's axes
    back to the torso's."""
    poses, *_ = play(dbc, legs(), quiet(), duration_s=2)
    position_m, _ = vectors(poses)
    moved_m = Rotation.from_euler("x", 90, degrees=True).apply(position_m[-1] - position_m[0])
    np.testing.assert_allclose(moved_m, [0.1, -0.2, 0.3], atol=2e-6)


def test_stamps_latency_and_status(dbc):
    start_us = 2**32 - 700_000  # so that the clock wraps during the run
    poses, status, _ = play(dbc, legs(), quiet(rate_hz=125, latency_s=0.0123, clock_start_us=start_us))
    measured_us = np.arange(len(poses)) * 8000
    assert [pose["t_us"] for _, pose in poses] == [(start_us + int(t)) % 2**32 for t in measured_us]
    after_ready_us = np.array([end_ns for end_ns, _ in poses]) / 1000 - (measured_us + 12_300)
    assert after_ready_us.min() > 50 and after_ready_us.max() < 250, "a frame's duration, after at most one other frame"
    assert [round((end_ns - 100_000) / 1e7) for end_ns, _ in status] == [2 * i for i in range(100)], "every 20 ms"
    assert {(s["period_us"], s["latency_us"], s["fault"]) for _, s in status} == {(8000, 12300, 0)}


def test_lost_samples_are_invalid_and_counted(dbc):
    poses, status, statistics = play(dbc, legs(), quiet(gap_start_s=0.6, gap_duration_s=0.1))
    invalid_us = [pose["t_us"] for _, pose in poses if not pose["valid"]]
    assert invalid_us == list(range(600_000, 700_000, 4000))
    assert (statistics.lost, statistics.range_errors) == (25, 0)
    assert statistics.longest_gap_s == pytest.approx(0.104)
    assert status[-1][1]["lost_samples"] == 25


def test_hand_out_of_sight_is_invalid(dbc):
    hidden = range(907, 1094)  # in ms

    def motion(time_s, pose):
        pose.position_m, pose.rotation = [time_s, 0, 0], [1, 0, 0, 0]
        return round(time_s * 1000) not in hidden

    poses, *_ = play(dbc, motion, quiet())
    invalid_us = [pose["t_us"] for _, pose in poses if not pose["valid"]]
    assert invalid_us == list(range(908_000, 1_094_000, 4000))
    # at a period of 6.25 ms, samples fall between ticks, and are invalid if the hand is hidden in one neighbouring tick
    between, *_ = play(dbc, motion, quiet(rate_hz=160, latency_s=0.01))
    invalid_us = [pose["t_us"] for _, pose in between if not pose["valid"]]
    assert invalid_us == [t for t in range(0, 1_990_000, 6250) if 906_000 < t < 1_094_000]


@pytest.mark.parametrize("latency_s", [0.0, 0.0005, 0.5])
def test_hand_is_measured_between_the_ticks(dbc, latency_s):
    """Samples at 333 Hz fall between ticks of 1 ms. They are interpolated between the ticks or, without latency,
    extrapolated by less than a tick. The error of either is at most f'' h^2 for a displacement f, with h = 1 ms, plus
    half a micrometre of resolution."""
    poses, *_ = play(
        dbc,
        legs(turn_rad=(0, 0, 0)),
        quiet(rate_hz=333, latency_s=latency_s, mount_translation_m=[0] * 3, mount_rotation=[1, 0, 0, 0]),
    )
    position_m, _ = vectors(poses)
    t = np.round(np.arange(len(poses)) * 1e9 / 333) * 1e-9
    x = np.clip(t - 0.5, 0, 1)[:, None]
    expected_m = np.array([0.2, -0.1, 0.1]) + (10 * x**3 - 15 * x**4 + 6 * x**5) * np.array([0.1, -0.2, 0.3])
    # for a move of 1 s over a distance d, f'' peaks at 10 / sqrt(3) d per s^2
    largest_m = 10 / np.sqrt(3) * np.array([0.1, 0.2, 0.3]) * 1e-6
    assert (np.abs(position_m - expected_m) < largest_m + 0.6e-6).all()
    assert len(poses) == len([k for k in range(700) if k / 333 + latency_s < 2])


def test_history_covers_the_longest_latency_and_no_more():
    history = ffi.gc(lib.hand_history_create(), lib.hand_history_destroy)
    pose = ffi.new("rigid_pose_t *", {"position_m": [0, 0, 0], "rotation": [1, 0, 0, 0]})
    assert not lib.hand_history_sample(history, 0, pose), "the history is empty"
    for tick in range(100, 3000):
        pose.position_m = [tick, 0, 0]
        sign, half_rad = (-1.0) ** tick, 0.0005 * tick
        pose.rotation = [sign * np.cos(half_rad), 0, 0, sign * np.sin(half_rad)]  # 1 mrad per tick, with either sign
        lib.hand_history_push(history, tick * TICK_NS, pose, True)

    def at(time_ms):
        return lib.hand_history_sample(history, round(time_ms * TICK_NS), pose) and pose.position_m[0]

    assert [at(t) for t in (2400, 2500.25, 2999, 2999.5, 3000)] == pytest.approx([2400, 2500.25, 2999, 2999.5, 3000])
    assert at(3500) == pytest.approx(3000), "extrapolated by one tick at most"
    assert at(2500.25) and (rotation(list(pose.rotation)) * Rotation.from_rotvec([0, 0, -2.50025])).magnitude() < 1e-9
    assert at(2000) is False and at(99) is False


def test_dropouts_have_their_rate_and_change_no_other_sample(dbc):
    complete, *_ = play(dbc, legs(), options(seed=5), duration_s=8)
    poses, _, statistics = play(dbc, legs(), options(seed=5, dropout_probability=0.2), duration_s=8)
    assert statistics.lost == sum(not pose["valid"] for _, pose in poses)
    share, deviation = statistics.lost / len(poses), np.sqrt(0.2 * 0.8 / len(poses))
    assert abs(share - 0.2) < 4 * deviation
    for (_, pose), (_, other) in zip(poses, complete, strict=True):
        assert not pose["valid"] or {**pose, "e2e_crc": 0} == {**other, "e2e_crc": 0}


def test_out_of_range_is_invalid_and_counted(dbc):
    """A position is sent as 24 bits in micrometres, so it is at most 8.388607 m. Samples beyond that range are invalid
    and counted."""
    motion = legs(displacement_m=(20, 0, 0), turn_rad=(0, 0, 0), start=(0, 0, 0), start_s=0)
    poses, status, statistics = play(dbc, motion, quiet(mount_translation_m=[0, 0, 0]))
    x = np.clip(np.arange(len(poses)) / 250, 0, 1)
    beyond = 20 * (10 * x**3 - 15 * x**4 + 6 * x**5) > 8.3886075
    assert [not pose["valid"] for _, pose in poses] == beyond.tolist()
    assert statistics.range_errors == statistics.lost == beyond.sum()
    # The last status is due at 1.98 s. It already counts the pose that was measured 4 ms (the latency) earlier, because
    # that pose is sent at the same time.
    assert status[-1][1]["range_errors"] == np.count_nonzero(beyond[: 1976 // 4 + 1])


def test_noise_has_its_standard_deviation(dbc):
    still = legs(displacement_m=(0, 0, 0), turn_rad=(0, 0, 0))
    noise = {"noise_position_m": 1e-3, "noise_rotation_rad": 0.01, "rate_hz": 1000}
    poses, *_ = play(dbc, still, options(**noise), duration_s=5)
    position_m, quaternion = vectors(poses)
    reference = rotation(vectors(play(dbc, still, quiet(), duration_s=0.1)[0])[1][0])
    turn_rad = (reference.inv() * rotation(quaternion)).as_rotvec()
    np.testing.assert_allclose(position_m.std(axis=0), 1e-3, rtol=0.05)
    np.testing.assert_allclose(turn_rad.std(axis=0), 0.01, rtol=0.05)
    assert abs(np.corrcoef(np.hstack([position_m, turn_rad]).T) - np.eye(6)).max() < 0.06


def test_seed_alone_decides_the_run(dbc):
    lossy = {"dropout_probability": 0.1}
    first, status, _ = play(dbc, legs(), options(seed=3, **lossy))
    again, status_again, _ = play(dbc, legs(), options(seed=3, **lossy), step_ns=20_000_000)
    other, *_ = play(dbc, legs(), options(seed=4, **lossy))
    assert (first, status) == (again, status_again)
    assert first != other


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rate_hz": 14.9}, "tracker: rate_hz is 14.9, expected 15 to 1000"),
        ({"rate_hz": float("nan")}, "tracker: rate_hz is nan, expected 15 to 1000"),
        ({"latency_s": -1e-3}, "tracker: latency_s is -0.001, expected 0 to 0.5"),
        ({"dropout_probability": 1.5}, "tracker: dropout_probability is 1.5, expected 0 to 1"),
        ({"mount_rotation": [2, 0, 0, 0]}, "tracker: norm of mount_rotation is 2, expected 0.999 to 1.001"),
    ],
)
def test_wrong_options_are_named(change, message):
    error = ffi.new("char[]", 200)
    assert lib.tracker_options_check(options(), error, 200)
    assert not lib.tracker_options_check(options(**change), error, 200)
    assert ffi.string(error).decode() == message


# ---- random numbers


def test_generator_is_sfc64():
    """The generator matches numpy's SFC64, which has the state a, b, c, counter."""
    generator = ffi.new("random_t *")
    lib.random_init(generator, 42, b"name")
    reference = np.random.SFC64()
    reference.state = {**reference.state, "state": {"state": np.array(list(generator.word), np.uint64)}}
    assert [lib.random_bits(generator) for _ in range(1000)] == reference.random_raw(1000).tolist()
    expected = np.random.Generator(reference).random(1000)
    assert [lib.random_uniform(generator) for _ in range(1000)] == expected.tolist()


def test_streams_differ_and_gaussians_are_normal():
    numbers = {}
    for seed, name in ((1, b"a"), (1, b"b"), (2, b"a")):
        generator = ffi.new("random_t *")
        lib.random_init(generator, seed, name)
        numbers[seed, name] = np.array([lib.random_gaussian(generator) for _ in range(50_000)])
    for values in numbers.values():
        assert kstest(values, "norm").pvalue > 1e-3
        assert abs(values.std() - 1) < 4 / np.sqrt(2 * len(values))
        assert abs(np.corrcoef(values[:-1], values[1:])[0, 1]) < 0.02
    assert abs(np.corrcoef(list(numbers.values())) - np.eye(3)).max() < 0.02
