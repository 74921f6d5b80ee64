"""Checks the simulated bus against the computed worst cases: arbitration under contention, response times in
constructed worst cases, and response times in the logs of the five experiments."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import bus_log
import can_classic_bits
import numpy as np
import pytest
from bus_log import DBC
from can_fd_bits import LENGTHS, frame_duration_ns
from comanip.bus.frame_length import BitRates, longest
from comanip_dev.bus.response_time import analyse
from comanip_dev.bus.traffic import (
    ANSWER_US,
    COMPUTING_US,
    Frame,
    classic_boot_frames,
    classic_frames,
    fd_boot_frames,
    fd_frames,
    streams,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from sim_bus import Bus
from simulation import EXPERIMENTS, experiment, shared

RATES = BitRates(1_000_000, 5_000_000)
TICK_NS, MS_NS, US_NS = 1_000_000, 1_000_000, 1000
COMPUTING_NS, ANSWER_NS = COMPUTING_US * US_NS, ANSWER_US * US_NS
LOG_NS = 1000  # log times are whole microseconds


# ---- arbitration: invariants for any traffic


@settings(max_examples=300, deadline=None, derandomize=True)
@given(
    st.lists(
        st.tuples(st.integers(0, 4), st.integers(0, 30), st.sampled_from(LENGTHS), st.integers(0, 40)), max_size=60
    )
)
def test_arbitration_under_contention(traffic):
    """The wire is never idle while a frame is ready, and the frame that starts has the lowest id of all ready frames.
    Frames with the same id from the same node keep their order: the later frame counts as ready only once the earlier
    frame has started."""
    bus = Bus(5)
    waiting = []
    for number, (node, tens, length, ready_10us) in enumerate(traffic):
        identifier = 8 * tens + node  # each id has a single sender
        data = bytes([number] * length)
        ready_ns = max([10_000 * ready_10us, *(w[1] for w in waiting if w[0] == identifier)])
        assert bus.send(node, identifier, data, 10_000 * ready_10us)
        waiting.append((identifier, ready_ns, number, data))
    bus.run_until(10**9)
    assert len(bus.heard) == len(traffic)
    free_ns = 0
    for identifier, data, end_ns, _ in bus.heard:
        start_ns = end_ns - frame_duration_ns(identifier, data)
        assert start_ns == max(free_ns, min(item[1] for item in waiting)), (
            "a frame starts as soon as the wire is free and a frame is ready"
        )
        own = min(item for item in waiting if item[1] <= start_ns)
        assert (own[0], own[3]) == (identifier, data), "of all ready frames, the one with the lowest id starts"
        waiting.remove(own)
        free_ns = end_ns


# ---- the worst case of each frame, with the longest payloads


def worst_case(frames: list[Frame], frame: Frame) -> tuple[int, int]:
    """Returns two response times of the frame on the simulated bus: one from when the frame was queued, the other from
    when the firmware's frames were queued. All frames of higher priority are queued just after the longest frame of
    lower priority has started."""
    node = {
        name: number
        for number, name in enumerate(("Firmware", "Drives", "Tracker", "Operator", "Gripper", "Proximity"))
    }
    bus = Bus(len(node))
    sent_by = {message.frame_id: node[message.senders[0]] for message in DBC.messages}
    payload = {item.name: longest(item.identifier, item.length, RATES).payload for item in frames}

    def send(item: Frame, ready_ns: int) -> None:
        assert bus.send(sent_by[item.identifier], item.identifier, payload[item.name], ready_ns)

    lower = [item for item in frames if item.identifier > frame.identifier]
    if lower:
        send(max(lower, key=lambda item: longest(item.identifier, item.length, RATES).duration_ns), 0)
    answers = [item for item in frames if item.answers == "JointCmd" and item.identifier <= frame.identifier]

    def drives(identifier: int, end_ns: int) -> None:
        if identifier == 0x050:
            queued_ns.setdefault("answers", end_ns + ANSWER_NS)
            for answer in answers:
                send(answer, end_ns + ANSWER_NS)

    queued_ns: dict[str, int] = {}
    bus.reaction[node["Drives"]] = drives
    higher = [item for item in frames if item.identifier <= frame.identifier and item.answers is None]
    if frame.one_of:
        higher = [item for item in higher if item is frame or item.one_of != frame.one_of]
    chosen: dict[str, Frame] = {}
    for item in higher:
        key = item.one_of or item.name
        if key not in chosen or len(payload[item.name]) > len(payload[chosen[key].name]):
            chosen[key] = item
    start_ns = 1 if lower else 0
    for item in chosen.values():
        send(item, start_ns)
    bus.run_until(50 * MS_NS)
    end_ns = next(end for identifier, _, end, _ in bus.heard[1 if lower else 0 :] if identifier == frame.identifier)
    queued = queued_ns["answers"] if frame in answers else start_ns
    return end_ns - queued, end_ns - start_ns


@pytest.mark.parametrize("joints", [4, 6, 8])
def test_the_worst_case_is_within_the_bound_and_close_to_it(joints):
    """No response time exceeds its bound. For a joint state that arrives within one tick, the response time (without
    the firmware's computing time) is only 1 ns below the bound, because the frame of lower priority starts 1 ns before
    the others are queued."""
    frames = fd_frames(joints)
    found = analyse(streams(frames, RATES), RATES.nominal_ns)
    reached = []
    for frame in frames:
        if frame.name == "GripperState, answer":
            continue
        queued_ns, since_tick_ns = worst_case(frames, frame)
        bound = found[frame.name]
        assert queued_ns <= bound.queued_ns, frame.name
        if frame.answers and bound.event_ns <= TICK_NS:
            assert since_tick_ns == bound.event_ns - COMPUTING_NS - 1, frame.name
            reached.append(frame.name)
        elif frame.identifier <= 0x120:
            assert queued_ns == bound.queued_ns - 1, frame.name
            reached.append(frame.name)
    assert len(reached) == 7 + 4, reached


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.randoms(use_true_random=False), st.sampled_from([4, 8]))
def test_random_phases_stay_within_the_bound(chance, joints):
    """No response time exceeds its bound in 100 ms of traffic in which all cyclic frames have their maximum length,
    each sender has a random phase, the operator sends requests at the minimum interval, and the firmware computes for 0
    to 50 us."""
    frames = {item.name: item for item in fd_frames(joints)}
    found = analyse(streams(list(frames.values()), RATES), RATES.nominal_ns)
    until_ns = 100 * MS_NS
    bus = Bus(6)
    queued: dict[str, list[int]] = {}

    def send(name: str, node: int, ready_ns: int) -> None:
        item = frames[name]
        assert bus.send(node, item.identifier, longest(item.identifier, item.length, RATES).payload, ready_ns)
        queued.setdefault(name, []).append(ready_ns)

    def drives(identifier: int, end_ns: int) -> None:
        if identifier == 0x050:
            for joint in range(joints):
                send(f"JointState{joint}", 1, end_ns + ANSWER_NS)

    bus.reaction[1] = drives
    others = {"Clearance": 5, "HandPose": 2, "GripperState": 4, "TrackerStatus": 2}
    due_ns = {name: chance.randrange(frames[name].period_ms * MS_NS) for name in others}
    request_ns = chance.randrange(2 * MS_NS)
    for tick in range(until_ns // TICK_NS):
        tick_ns = tick * TICK_NS
        for name in due_ns:
            while due_ns[name] < tick_ns + TICK_NS:
                send(name, others[name], due_ns[name])
                due_ns[name] += frames[name].period_ms * MS_NS
        answered = False
        if request_ns < tick_ns + TICK_NS:
            send(chance.choice(["OperatorCommand", "TaskDefine", "ParameterAccess"]), 3, request_ns)
            request_ns += 2 * MS_NS
            answered = True
        at_ns = tick_ns + chance.choice([0, COMPUTING_NS])
        for name, item in frames.items():
            if item.batch and item.is_cyclic and tick % item.period_ms == 0:
                send(name, 0, at_ns)
        if answered:
            send(chance.choice(["CommandAck", "ParameterValue"]), 0, at_ns)
        bus.run_until(tick_ns + TICK_NS)
    bus.run_until(until_ns + 100 * MS_NS)
    assert bus.statistics.dropped == 0
    for name, ready_ns in queued.items():
        ends_ns = [end for identifier, _, end, _ in bus.heard if identifier == frames[name].identifier]
        assert len(ends_ns) == len(ready_ns)
        worst_ns = max(end - ready for end, ready in zip(ends_ns, ready_ns, strict=True))
        assert worst_ns <= found[name].queued_ns, name
    assert len(queued) >= 8 + joints + 2  # cyclic frames, joint states, and a request with its acknowledgement


# ---- the five experiments, in both profiles


@dataclass(frozen=True)
class Profile:
    """A bus profile. `prefix` is the prefix of the profile's message names, `sync` the message that the drives
    answer."""

    name: str
    prefix: str
    rates: BitRates
    running: list[Frame]
    booting: list[Frame]
    duration_ns: Callable[[int, bytes], int]
    tick_ms: int
    event_ticks: int
    sync: str
    least_ratio: float  # least ratio of a control frame's longest response time to its bound

    def plain(self, name: str) -> str:
        return name.removeprefix(self.prefix)


PROFILES = {
    "fd": Profile("fd", "", RATES, fd_frames(4), fd_boot_frames(), frame_duration_ns, 1, 2, "JointCmd", 0.4),
    "classic": Profile(
        "classic", "Classic", BitRates(1_000_000), classic_frames(4), classic_boot_frames(),
        can_classic_bits.frame_duration_ns, 4, 1, "ClassicJointCmd3", 0.35,
    ),
}  # fmt: skip


@dataclass(frozen=True)
class Log:
    profile: Profile
    frames: dict[str, bus_log.Frames]
    ends_ns: dict[str, np.ndarray]

    def tick_before_ns(self, times_ns: np.ndarray) -> np.ndarray:
        """Returns the time of the last firmware tick before each time. The first tick is at 1 ms."""
        tick_ns = self.profile.tick_ms * MS_NS
        return (times_ns - MS_NS) // tick_ns * tick_ns + MS_NS

    def queued_ns(self, name: str) -> np.ndarray | None:
        """Returns when each frame with this name was queued. The time of a cyclic frame follows from its number, and
        that of an answer from the frame it answers. Returns None for requests, because the log does not show when the
        operator queued them."""
        count, plain = np.arange(len(self.frames[name])), self.profile.plain(name)
        if plain.startswith("JointState"):
            return self.ends_ns[self.profile.sync][count] + ANSWER_NS
        if plain == "GripperState":
            requests = self.ends_ns.get(f"{self.profile.prefix}GripperCommand", np.array([], int)) + ANSWER_NS
            cyclic = np.arange(len(count) - len(requests)) * 20 * MS_NS
            return np.sort(np.concatenate([cyclic, requests]))
        message = DBC.get_message_by_name(name)
        if message.senders == ["Firmware"]:
            if message.cycle_time:
                phase_ms = self.profile.tick_ms if plain.startswith("Port") else 0  # one tick after the heartbeat
                return (1 + phase_ms + count * message.cycle_time) * MS_NS + COMPUTING_NS
            payloads = [bytes(data) for data in self.frames[name].data]
            starts_ns = self.ends_ns[name] - np.array([self.profile.duration_ns(message.frame_id, d) for d in payloads])
            return self.tick_before_ns(starts_ns + LOG_NS - COMPUTING_NS) + COMPUTING_NS
        latency_ns = 4 * MS_NS if plain in ("HandPose", "HandPosition", "HandRotation") else 0  # latency of the tracker
        return latency_ns + count * message.cycle_time * MS_NS if message.cycle_time else None


@pytest.fixture(scope="module", params=[(s, p) for p in PROFILES for s in EXPERIMENTS], ids="-".join)
def logged(request):
    scenario, profile = request.param
    done = shared("--scenario", experiment(scenario), "--seed", 1, *(() if profile == "fd" else ("--profile", profile)))
    frames = bus_log.read(done.log)
    return Log(
        PROFILES[profile], frames, {name: np.rint(own.t_s * 1e9).astype(np.int64) for name, own in frames.items()}
    )


BOOT_NS = 100 * MS_NS  # at a tick rate of 1 kHz


def test_responses_in_the_experiments_are_within_the_bounds(logged):
    """No response exceeds its bound, and the bounds are not overly pessimistic: the longest response of each control
    frame is a fair share of its bound (0.46 to 0.75 on CAN FD, at least 0.36 on classic CAN). Some other frames stay
    far below their bounds: in the simulator all phases are fixed, so that they never have to wait for another frame."""
    profile, frames = logged.profile, logged.frames
    running = analyse(streams(profile.running, profile.rates), profile.rates.nominal_ns)
    booting = analyse(streams([*profile.running, *profile.booting], profile.rates), profile.rates.nominal_ns)
    judged, ratios = set(), {}
    for name in frames:
        queued_ns = logged.queued_ns(name)
        if queued_ns is None:
            continue
        response_ns = logged.ends_ns[name] - queued_ns
        assert response_ns.min() > 0, f"{name}: queued after its end, so this test models the schedule wrongly"
        is_boot = queued_ns < profile.tick_ms * BOOT_NS
        at_boot = booting.get(f"{name}, boot", booting.get(name))
        if profile.plain(name) == "ParameterValue":
            is_boot |= frames[name].raw("sequence") == 0
        assert np.all(response_ns[is_boot] <= at_boot.queued_ns + LOG_NS), name
        if not np.all(is_boot):
            longest_ns = response_ns[~is_boot].max()
            assert longest_ns <= running[name].queued_ns + LOG_NS, f"{name}: {longest_ns} ns"
            ratios[profile.plain(name)] = longest_ns / running[name].queued_ns
        judged.add(profile.plain(name))
    requests = {"OperatorCommand", "TaskDefine", "ParameterAccess", "GripperCommand"}
    requests |= {"TaskTranslation", "TaskRotation", "TaskInverse"}
    assert judged == {profile.plain(name) for name in frames} - requests and len(judged) >= 14
    control = ["TickTrace", *(f"JointState{joint}" for joint in range(4))]
    control += ["JointCmd", "HandPose"] if profile.name == "fd" else ["JointCmd3"]
    for name in control:
        assert ratios[name] > profile.least_ratio, (name, ratios)


def test_events_are_as_rare_as_assumed(logged):
    """Any n + 1 successive acknowledgements span at least 2 n - 1 ticks, or n ticks on classic CAN."""
    frames, prefix = logged.frames, logged.profile.prefix
    acknowledged = [logged.queued_ns(f"{prefix}CommandAck")]
    if f"{prefix}ParameterAccess" in frames:
        is_answer = frames[f"{prefix}ParameterValue"].raw("sequence") != 0
        acknowledged.append(logged.queued_ns(f"{prefix}ParameterValue")[is_answer])
    ticks = np.sort(np.concatenate(acknowledged)) // (logged.profile.tick_ms * MS_NS)
    requests = [f"{prefix}{name}" for name in ("OperatorCommand", "TaskDefine", "ParameterAccess")]
    assert len(ticks) == sum(len(frames[name]) for name in requests if name in frames)
    for apart in range(1, len(ticks)):
        assert np.all(ticks[apart:] - ticks[:-apart] >= logged.profile.event_ticks * (apart - 1) + 1)
