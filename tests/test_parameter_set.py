"""Tests which sets of parameters are refused, how refusals are reported, and that no error shrinks faster than the
criterion assumes."""

from __future__ import annotations

import numpy as np
import oracle
import pytest
from comanip._core import ffi, lib
from controller_bench import FRAME_ID, Bench
from simulation import EXIT_CHECK_FAILED, run

TICK_S = 1e-3
CLASSIC_TICK_S = 4e-3
GAINS = range(lib.PARAMETER_GAIN_PER_S, lib.PARAMETER_GAIN_PER_S + 8)
WEIGHTS = range(lib.PARAMETER_WEIGHT, lib.PARAMETER_WEIGHT + 8)
NAMES = [ffi.string(lib.parameter_table[i].name).decode() for i in range(lib.PARAMETER_COUNT)]
TOO_FAST = dict.fromkeys(GAINS, 500.0)
LAW_4 = {lib.PARAMETER_PREDICTION: 0.0}
FOLLOWING_GAIN = lib.PARAMETER_FOLLOWING_GAIN_PER_S


def parameters(changes: dict[int, float]):
    values = ffi.new("parameters_t *")
    lib.parameters_set_defaults(values)
    for parameter, value in changes.items():
        assert lib.parameters_set(values, parameter, value) == lib.RESULT_ACCEPTED
    return values


def check(changes: dict[int, float], tick_s: float = TICK_S) -> tuple[int, set[int]]:
    found = lib.parameter_set_check(parameters(changes), tick_s)
    return found.verdict, {i for i in range(lib.PARAMETER_COUNT) if found.involved >> i & 1}


# ---- the verdict


@pytest.mark.parametrize("tick_s", [TICK_S, CLASSIC_TICK_S])
def test_the_defaults_and_all_slower_gains_are_accepted(tick_s):
    slow = {
        "nothing": {},
        "gain": {FOLLOWING_GAIN: lib.parameter_table[FOLLOWING_GAIN].minimum},
        "gains": dict.fromkeys(GAINS, 0.0),
        "weights": dict.fromkeys(WEIGHTS, 0.0),
        "speed": {lib.PARAMETER_SPEED_FRACTION: lib.parameter_table[lib.PARAMETER_SPEED_FRACTION].minimum},
        "acceleration": {
            lib.PARAMETER_ACCELERATION_LIMIT_RADPS2: lib.parameter_table[
                lib.PARAMETER_ACCELERATION_LIMIT_RADPS2
            ].minimum
        },
    }
    for changes in (*slow.values(), slow["gains"] | slow["speed"] | slow["acceleration"]):
        assert check(changes, tick_s) == (lib.PARAMETER_SET_RESTS, set()), changes
        assert check(changes | LAW_4, tick_s) == (lib.PARAMETER_SET_MAY_SWING, {lib.PARAMETER_PREDICTION}), changes


def test_gains_are_refused_by_the_loops_delay():
    """Gains and a loop delay that are unstable together are refused. Only the responsible parameters are named: gains
    that are too large by themselves, a delay together with the default gains, or a delay together with a changed
    gain."""
    delay = lib.PARAMETER_COMMAND_DELAY_S
    assert check(LAW_4 | {3: 500.0}) == (lib.PARAMETER_SET_UNSTABLE, {3})
    assert check(LAW_4 | TOO_FAST) == (lib.PARAMETER_SET_UNSTABLE, set(GAINS))
    assert check(LAW_4 | {delay: 0.05}) == (lib.PARAMETER_SET_UNSTABLE, {*GAINS, delay})
    assert check(LAW_4 | {5: 60.0, delay: 0.015}) == (lib.PARAMETER_SET_UNSTABLE, {5, delay})
    for accepted in ({5: 60.0}, {delay: 0.015}, {5: 100.0}):
        assert check(LAW_4 | accepted)[0] == lib.PARAMETER_SET_MAY_SWING
    assert check(LAW_4 | {5: 100.0}, CLASSIC_TICK_S) == (lib.PARAMETER_SET_UNSTABLE, {5})


def test_the_following_gain_is_refused_by_the_loops_delay():
    fast, delay = {FOLLOWING_GAIN: 60.0}, {lib.PARAMETER_COMMAND_DELAY_S: 0.015}
    assert check(fast) == check(delay) == check(TOO_FAST) == (lib.PARAMETER_SET_RESTS, set())
    assert check(fast | delay) == (lib.PARAMETER_SET_UNSTABLE, {FOLLOWING_GAIN, lib.PARAMETER_COMMAND_DELAY_S})
    assert check({lib.PARAMETER_COMMAND_DELAY_S: 0.05})[0] == lib.PARAMETER_SET_UNSTABLE


def test_a_gain_without_a_weight_has_no_effect():
    assert check(LAW_4 | {3: 500.0, lib.PARAMETER_WEIGHT + 3: 0.0})[0] == lib.PARAMETER_SET_MAY_SWING


def test_the_papers_law_gives_a_warning_and_is_not_refused():
    paper = {**LAW_4, lib.PARAMETER_ERROR_FRAME: 0.0, **dict.fromkeys(WEIGHTS, 1.0)}
    assert check(paper | TOO_FAST) == (lib.PARAMETER_SET_MAY_SWING, set(GAINS))
    for change in ({lib.PARAMETER_ERROR_FRAME: 1.0}, {lib.PARAMETER_WEIGHT + 7: 1.5}):
        assert check(paper | TOO_FAST | change)[0] == lib.PARAMETER_SET_UNSTABLE


def test_no_error_shrinks_faster_than_the_largest_gain_with_a_weight(rng):
    """Confirms the assumption of the criterion in double precision: for any posture and weights, no eigenvalue of J
    N^-1 J^T W K, with dqrobotics' Jacobian, exceeds the largest gain whose weight is not zero."""
    arm = oracle.hoap3()
    _, jacobians = oracle.evaluate(arm, rng.uniform(*np.radians(oracle.HOAP3_RANGE_DEG), size=(50, 4)))
    for jacobian in jacobians:
        gain, weight = rng.uniform(0, 500, 8), 10.0 ** rng.uniform(-3, 4, 8) * (rng.random(8) < 0.8)
        damped = jacobian.T @ (weight[:, None] * jacobian) + 10.0 ** rng.uniform(-6, 0) * np.eye(4)
        rates = np.linalg.eigvals(jacobian @ np.linalg.solve(damped, jacobian.T * (weight * gain)))
        assert np.abs(rates.imag).max() < 1e-6 * 500
        assert rates.real.max() <= np.max(gain * (weight > 0)) + 1e-6 * 500
        assert rates.real.min() >= -1e-6 * 500


# ---- when a set takes effect


def named(bench: Bench, ticks: int) -> list[tuple[int, int]]:
    """Returns (parameter, sequence) of each ParameterValue that reports parameters_unstable. At most one is expected
    per tick."""
    found = []
    for _ in range(ticks):
        bench.tick()
        here = [
            (d[3], d[4])
            for i, d in bench.sent
            if i == FRAME_ID["PARAMETER_VALUE"] and d[5] == lib.RESULT_PARAMETERS_UNSTABLE
        ]
        assert len(here) <= 1
        found += here
    return found


def status_bit(bench: Bench) -> bool:
    bench.tick(2)
    frame = ffi.new("can_frame_t *")
    while not (found := [data for i, data in bench.sent if i == FRAME_ID["FIRMWARE_STATUS"]]):
        bench.tick()
    frame.length = len(found[0])
    ffi.memmove(frame.data, found[0], len(found[0]))
    message = ffi.new("firmware_status_t *")
    lib.firmware_status_unpack(frame, message)
    return message.rest_not_assured


def test_an_unstable_set_is_written_but_neither_started_nor_saved_until_corrected():
    bench = Bench(prediction=True).until_ready()
    bench.store_result = lib.RESULT_ACCEPTED
    assert not status_bit(bench)
    bench.write(lib.PARAMETER_PREDICTION, 0.0)
    for gain in (2, 5):
        assert bench.write(gain, 500.0) == lib.RESULT_ACCEPTED
    assert status_bit(bench)
    assert bench.command(lib.COMMAND_START) == lib.RESULT_PARAMETERS_UNSTABLE
    sequence = bench.sequence
    assert named(bench, 10) == [(2, sequence), (5, sequence)]
    assert bench.mode == lib.MODE_READY and (bench.velocity_radps == 0).all()
    assert bench.save(7) == lib.RESULT_PARAMETERS_UNSTABLE and bench.stored == []
    bench.write(2, 35.0)
    assert bench.command(lib.COMMAND_START) == lib.RESULT_PARAMETERS_UNSTABLE
    bench.write(5, 35.0)
    assert status_bit(bench)
    bench.write(lib.PARAMETER_PREDICTION, 1.0)
    assert not status_bit(bench)
    assert bench.save() == lib.RESULT_ACCEPTED and len(bench.stored) == 1
    assert bench.command(lib.COMMAND_START) == lib.RESULT_ACCEPTED


@pytest.mark.parametrize(
    ("profile", "parameters", "others"),
    [
        ("fd", {"command_delay_s": 0.02, "following_gain_per_s": 60}, {}),
        # the product of each gain and the loop's delay exceeds 0.8
        ("classic", {"prediction": 0, "command_delay_s": 0.02, "gain_x_per_s": 100, "gain_dual_y_per_s": 90},
         {f"gain_{axis}_per_s": 35 for axis in ("w", "y", "z", "dual_w", "dual_x", "dual_z")}),
    ],
)  # fmt: skip
def test_the_simulator_names_all_parameters_of_a_refused_start(tmp_path, profile, parameters, others):
    written = [part for name, value in parameters.items() for part in ("--param", f"{name}={value}")]
    done = run(tmp_path / "out", "--scenario", "teleop", "--profile", profile, *written)
    assert done.status == EXIT_CHECK_FAILED
    _, named = done.summary["reason"].split("refused by the firmware: parameters_unstable (mode ready): ")
    expected = {f"{name} = {value:g}" for name, value in {**parameters, **others}.items() if name != "prediction"}
    assert set(named.split(", ")) == expected


def test_a_stored_unstable_set_is_kept_reported_at_boot_and_not_started():
    bench = Bench(parameters=parameters(LAW_4 | {4: 500.0, 6: 400.0}))
    announced = {}
    for _ in range(lib.PARAMETER_COUNT + 10):
        bench.tick()
        announced |= {d[3]: d[5] for i, d in bench.sent if i == FRAME_ID["PARAMETER_VALUE"] and d[4] == 0}
    assert {i for i, result in announced.items() if result == lib.RESULT_PARAMETERS_UNSTABLE} == {4, 6}
    assert {result for i, result in announced.items() if i not in (4, 6)} == {lib.RESULT_ACCEPTED} and len(
        announced
    ) == lib.PARAMETER_COUNT
    assert (bench.controller.parameters.value[4], bench.controller.parameters.value[6]) == (500, 400)
    bench.until_ready()
    assert bench.command(lib.COMMAND_START) == lib.RESULT_PARAMETERS_UNSTABLE
    bench.write(4, 35.0)
    bench.write(6, 35.0)
    assert bench.command(lib.COMMAND_START) == lib.RESULT_ACCEPTED


def test_the_papers_law_starts_with_a_warning():
    bench = Bench().until_ready()
    for parameter, value in {lib.PARAMETER_ERROR_FRAME: 0.0, **dict.fromkeys(WEIGHTS, 1.0), **TOO_FAST}.items():
        assert bench.write(parameter, value) == lib.RESULT_ACCEPTED
    assert status_bit(bench)
    assert bench.command(lib.COMMAND_START) == lib.RESULT_ACCEPTED
