"""ODE's arm and its drives agree with numpy: kinematics, gravity, inertia, stops, torque limit, servo, encoder and
watchdog."""

from __future__ import annotations

import contextlib

import hoap3
import numpy as np
import plant_binding
import pytest
from scipy.spatial.transform import Rotation

TICK_S = 1e-3
TICK_NS = 1_000_000


@pytest.fixture(scope="module")
def sim():
    return plant_binding.load()


@contextlib.contextmanager
def plant_at(sim, q):
    """Provides the arm in its own world, and a function that steps this world by one tick."""
    ffi, lib = sim
    world = lib.physics_create()
    plant = lib.arm_plant_create(world, ffi.new("double[4]", list(q)))
    try:
        yield plant, lambda: lib.physics_step(world, TICK_S)
    finally:
        lib.arm_plant_destroy(plant)
        lib.physics_destroy(world)


def hand_of(sim, plant):
    ffi, lib = sim
    pose = ffi.new("rigid_pose_t *")
    lib.arm_plant_hand(plant, pose)
    w, x, y, z = pose.rotation
    return np.array(list(pose.position_m)), Rotation.from_quat([x, y, z, w])


def position(sim, plant):
    return np.array([sim[1].arm_plant_position_rad(plant, i) for i in range(4)])


def torque(sim, plant):
    return np.array([sim[1].arm_plant_torque_Nm(plant, i) for i in range(4)])


def command(sim, plant, velocity):
    for i, v in enumerate(velocity):
        sim[1].arm_plant_set_velocity(plant, i, float(v))


def assert_hand(sim, plant, q, position_m, angle_rad):
    expected = hoap3.frames(q)[4]
    at, rotation = hand_of(sim, plant)
    assert np.abs(at - expected[:3, 3]).max() < position_m
    assert (rotation.inv() * Rotation.from_matrix(expected[:3, :3])).magnitude() < angle_rad


def test_the_manuals_check_posture(sim):
    with plant_at(sim, np.radians([90, 0, 0, -90])) as (plant, _):
        at, rotation = hand_of(sim, plant)
        assert np.allclose(at, [0.136, -0.111, 0.014], atol=1e-9)
        assert np.allclose(rotation.apply([[1, 0, 0], [0, 0, 1]]), [[0, 0, 1], [1, 0, 0]], atol=1e-9)


def test_hand_at_random_postures(sim, rng):
    for _ in range(50):
        q = hoap3.random_posture(rng)
        with plant_at(sim, q) as (plant, _):
            assert np.allclose(position(sim, plant), q, atol=1e-9)
            assert_hand(sim, plant, q, 1e-9, 1e-7)


def test_joints_stay_connected_while_moving(sim, rng):
    """After a second of fast motion, the poses of ODE's bodies still agree with the joint angles."""
    for _ in range(5):
        with plant_at(sim, hoap3.random_posture(rng, 30.0)) as (plant, step):
            start = position(sim, plant)
            for tick in range(1000):
                if tick % 50 == 0:
                    command(sim, plant, rng.uniform(-2, 2, 4))
                step()
                if tick % 10 == 0:
                    assert_hand(sim, plant, position(sim, plant), 20e-6, 2e-4)
            assert np.abs(position(sim, plant) - start).max() > 0.05


def test_holding_torque_balances_gravity(sim, rng):
    for _ in range(20):
        q = hoap3.random_posture(rng)
        with plant_at(sim, q) as (plant, step):
            for _ in range(20):
                step()
            assert np.abs(position(sim, plant) - q).max() < 1e-5
            assert np.allclose(torque(sim, plant), hoap3.holding_torque(q), atol=2e-4)


def test_torque_of_a_velocity_step_is_inertia_times_it(sim, rng):
    """To change the velocities from rest by dv within one tick dt, the motors need the torque M(q) dv / dt in addition
    to the torque that holds the arm against gravity."""
    for _ in range(20):
        q, velocity = hoap3.random_posture(rng), rng.uniform(-0.03, 0.03, 4)
        with plant_at(sim, q) as (plant, step):
            command(sim, plant, velocity)
            step()
            expected = hoap3.inertia_matrix(q) @ velocity / TICK_S + hoap3.holding_torque(q)
            assert np.abs(expected).max() < 3.0
            assert np.allclose(torque(sim, plant), expected, atol=5e-5)  # ODE's joints are slightly compliant


def test_motors_have_a_torque_limit(sim):
    with plant_at(sim, np.radians([90, -40, 0, -60])) as (plant, step):
        command(sim, plant, [50.0, 0, 0, 0])
        step()
        assert torque(sim, plant)[0] == pytest.approx(3.0, abs=1e-9)
        assert sim[1].arm_plant_velocity_radps(plant, 0) < 2.0


@pytest.mark.parametrize("joint", range(4))
@pytest.mark.parametrize("side", [0, 1])
def test_mechanical_stops(sim, joint, side):
    start = np.radians([30, -45, 0, -60])
    with plant_at(sim, start) as (plant, step):
        velocity = np.zeros(4)
        velocity[joint] = 2.0 if side else -2.0
        command(sim, plant, velocity)
        for _ in range(3000):
            step()
        assert position(sim, plant)[joint] == pytest.approx(np.radians(hoap3.STOPS_DEG[joint, side]), abs=2e-3)


def test_same_commands_same_bits(sim, rng):
    velocity = rng.uniform(-1, 1, (300, 4))
    runs = []
    for _ in range(2):
        with plant_at(sim, np.radians([90, -5, 0, -90])) as (plant, step):
            for row in velocity:
                command(sim, plant, row)
                step()
            runs.append((position(sim, plant).tobytes(), hand_of(sim, plant)[0].tobytes()))
    assert runs[0] == runs[1]


class Drives:
    """Plant and drives on a bus. The class sends JointCmd and decodes JointState with cantools."""

    def __init__(self, sim, dbc, plant, step):
        self.ffi, self.lib = sim
        self.dbc, self.plant, self.step = dbc, plant, step
        self.bus = self.lib.bus_create(self.lib.CAN_PROFILE_FD)
        self.drives = self.lib.drive_node_create(self.bus, plant)
        self.node = self.lib.bus_attach(self.bus, self._callback(lambda frame: None), self.ffi.NULL)
        self.states = {}
        self._listener = self._callback(self._on_frame)
        self.lib.bus_listen(self.bus, self._listener, self.ffi.NULL)
        self.sender = self.ffi.new("protocol_sender_t *")
        self.now_ns = 0

    def _callback(self, function):
        callback = self.ffi.callback(
            "void(void *, const can_frame_t *, int64_t)", lambda _context, frame, _end_ns: function(frame)
        )
        self.__dict__.setdefault("_kept", []).append(callback)
        return callback

    def _on_frame(self, frame):
        if 0x180 <= frame.id < 0x188:
            data = bytes(frame.data[0 : frame.length])
            self.states[frame.id - 0x180] = self.dbc.decode_message(frame.id, data, decode_choices=False)

    def tick(self, velocity=None, mode=1, spoil=False):
        if velocity is not None:
            message, frame = self.ffi.new("joint_cmd_t *"), self.ffi.new("can_frame_t *")
            for i in range(4):
                message.mode[i], message.velocity_radps[i] = mode, velocity[i]
            assert self.lib.joint_cmd_pack(message, frame) == 0
            self.lib.protocol_protect(self.sender, frame)
            frame.data[20] ^= 1 if spoil else 0
            assert self.lib.bus_send(self.bus, self.node, frame, self.now_ns)
        self.now_ns += TICK_NS
        self.states = {}
        self.lib.bus_run_until(self.bus, self.now_ns)
        self.lib.drive_node_step(self.drives, self.now_ns, TICK_S)
        self.step()

    def close(self):
        self.lib.drive_node_destroy(self.drives)
        self.lib.bus_destroy(self.bus)


@pytest.fixture
def drives(sim, dbc):
    with plant_at(sim, np.radians([60, -30, 10, -80])) as (plant, step):
        rig = Drives(sim, dbc, plant, step)
        yield rig
        rig.close()


def test_encoder_counts_whole_pulses(sim, drives):
    for _ in range(300):
        at = position(sim, drives.plant)
        drives.tick([0.3, -0.2, 0.25, 0.15])
        assert sorted(drives.states) == [0, 1, 2, 3]
        for i, state in drives.states.items():
            pulses = state["position_rad"] * hoap3.PULSES_PER_RAD
            assert pulses == pytest.approx(round(pulses), abs=0.02)  # the frame's resolution of 1 urad is 0.012 pulses
            assert abs(state["position_rad"] - at[i]) < 0.52 / hoap3.PULSES_PER_RAD


def test_reported_velocity_and_torque(sim, drives):
    for _ in range(100):
        drives.tick([0.3, -0.2, 0.25, 0.15])
    for i, velocity in enumerate([0.3, -0.2, 0.25, 0.15]):
        # eight samples span 7 ms, so one encoder pulse more or less changes the reported velocity by 12 mrad/s
        assert drives.states[i]["velocity_radps"] == pytest.approx(velocity, abs=0.013)
    for _ in range(100):
        drives.tick([0.0] * 4)
    expected = hoap3.holding_torque(position(sim, drives.plant))
    assert [drives.states[i]["torque_Nm"] for i in range(4)] == pytest.approx(list(expected), abs=0.0051)


def test_servo_is_a_first_order_lag_of_3_ms(sim, drives):
    for n in range(1, 20):
        drives.tick([0.2, 0.1, -0.1, 0.15])
        for i, velocity in enumerate([0.2, 0.1, -0.1, 0.15]):
            expected = velocity * (1 - np.exp(-n / 3.0))
            assert sim[1].arm_plant_velocity_radps(drives.plant, i) == pytest.approx(expected, abs=2e-4)


def test_silent_before_the_first_command(sim, drives):
    before = position(sim, drives.plant)
    for _ in range(20):
        drives.tick()
        assert drives.states == {}
    assert np.allclose(position(sim, drives.plant), before, atol=1e-6)


def test_watchdog_brakes_and_is_reported(sim, drives):
    for _ in range(50):
        drives.tick([0.3, 0, 0, 0])
    assert drives.states[0]["error"] == 0 and drives.states[0]["mode"] == 1
    errors = []
    for _ in range(10):
        drives.tick()
        errors.append(drives.states.get(0, {}).get("error"))
    assert errors.index(1) in (3, 4)  # the drives' watchdog acts after 3 ms, and the state is sent a tick later
    assert set(errors[errors.index(1) :]) == {1} and drives.states[3]["mode"] == 0
    assert sim[1].arm_plant_velocity_radps(drives.plant, 0) == pytest.approx(0.0, abs=1e-6)
    drives.tick([0.1, 0, 0, 0])
    assert drives.states[0]["error"] == 0 and drives.states[0]["mode"] == 1


def test_disabled_drives_brake_whatever_is_commanded(sim, drives):
    _, lib = sim
    for _ in range(20):
        drives.tick([0.3, -0.2, 0.25, 0.15])
    lib.drive_node_enable(drives.drives, False)
    for _ in range(20):
        drives.tick([0.3, -0.2, 0.25, 0.15])
        assert {(state["mode"], state["error"]) for state in drives.states.values()} == {(0, 0)}
        assert np.abs([lib.arm_plant_velocity_radps(drives.plant, i) for i in range(4)]).max() < 1e-6
    lib.drive_node_enable(drives.drives, True)
    drives.tick()
    # enabling the drives causes no motion by itself
    assert np.abs([lib.arm_plant_velocity_radps(drives.plant, i) for i in range(4)]).max() < 1e-6
    drives.tick([0.3, -0.2, 0.25, 0.15])
    assert {state["mode"] for state in drives.states.values()} == {1}
    assert np.abs([lib.arm_plant_velocity_radps(drives.plant, i) for i in range(4)]).min() > 0.01


def test_a_damaged_command_is_ignored(sim, drives):
    drives.tick([0.0] * 4)
    for _ in range(2):
        drives.tick([0.5] * 4, spoil=True)
        assert drives.states == {}
    assert np.abs([sim[1].arm_plant_velocity_radps(drives.plant, i) for i in range(4)]).max() < 1e-6
    assert sim[1].drive_node_rejected(drives.drives) == 2
