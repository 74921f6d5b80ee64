"""``comanip calibrate``: estimates the tracker's rotation relative to the robot."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from comanip.bus import logs
from comanip.bus.frame import Frame, decode
from comanip.bus.live import BusAddress, LiveBus, open_bus
from comanip.bus.operator_client import OperatorClient
from comanip.bus.transport import Receiver
from comanip.commands.options import console, examples, takes_bus
from comanip.errors import ToolError
from comanip.tracker import pose_lines
from comanip.tracker.calibration import MOVES, PARAMETERS, Calibration, CalibrationError, Move, MoveDetector, solve

HELP = examples(
    "comanip calibrate                                guides you, reads the bus, prints the `param set` commands",
    "comanip calibrate --set -i socketcand            writes the parameters into the firmware instead",
    "comanip calibrate --from moves.csv               from a recording: t_s,x_m,y_m,z_m,qw,qx,qy,qz",
    "comanip calibrate --from out/calibration/bus.log",
)
MOVES_TIMEOUT_S = 60.0
CLOCK_US = 2**32
Sample = tuple[float, np.ndarray]  # time [s], position [m] in the tracker's frame


class _Unwrapped:
    """Converts times of the tracker's 32-bit clock, which wraps around, to seconds that do not wrap."""

    def __init__(self):
        self._last_us, self._wraps = 0, 0

    def seconds(self, t_us: int) -> float:
        if t_us < self._last_us - CLOCK_US // 2:
            self._wraps += 1
        self._last_us = t_us
        return (self._wraps * CLOCK_US + t_us) / 1e6


def hand_samples(frames: Iterable[Frame | None]) -> Iterator[Sample]:
    """Yields the samples of the valid HandPose frames."""
    clock, receiver = _Unwrapped(), Receiver()
    for frame in (received and receiver.message(received) for received in frames):
        if frame is None or frame.name != "HandPose" or (pose := decode(frame)) is None or not pose["valid"]:
            continue
        yield clock.seconds(int(pose["t_us"])), np.array([pose["x_m"], pose["y_m"], pose["z_m"]])


def recorded_samples(path: Path) -> Iterator[Sample]:
    """Yields the samples of a text file: a recording (docs/recordings.md), or other lines that `comanip tracker`
    accepts, with timestamps."""
    try:
        with open(path, encoding="utf-8") as lines:
            for number, line in enumerate(lines, 1):
                try:
                    pose = pose_lines.parse(line)
                except ValueError as error:
                    raise ToolError(f"{path}:{number}: {error}") from error
                if pose is None:
                    continue
                if pose.t_s is None:
                    raise ToolError(f"{path}:{number}: no timestamp, expected one at the start of each line")
                yield pose.t_s, np.array(pose.position_m)
    except (OSError, UnicodeDecodeError) as error:
        raise ToolError(f"{path}: cannot be read as text: {error}") from error


def found_moves(samples: Iterable[Sample]) -> Iterator[Move]:
    detector = MoveDetector()
    for t_s, position_m in samples:
        move = detector.feed(t_s, position_m)
        if move is not None:
            yield move


def _frames(bus: LiveBus) -> Iterator[Frame | None]:
    deadline_s = time.monotonic() + MOVES_TIMEOUT_S
    while time.monotonic() < deadline_s:
        yield bus.receive(0.1)


def _guide(bus: LiveBus) -> list[Move]:
    out = console()
    detector, moves = MoveDetector(), []
    out.print("Hold the marked hand still.")
    for t_s, position_m in hand_samples(_frames(bus)):
        was_resting = detector.is_resting
        move = detector.feed(t_s, position_m)
        if detector.is_resting and not was_resting:
            out.print(
                f"1/{len(MOVES)}: move the hand straight {MOVES[0]}, as seen by the robot, by 20 cm or more, "
                "and hold it still."
            )
        if move is None:
            continue
        moves.append(move)
        out.print(f"  {100 * move.length_m:.0f} cm, {100 * move.crooked:.1f} % off a straight line")
        if len(moves) == len(MOVES):
            return moves
        out.print(f"{len(moves) + 1}/{len(MOVES)}: now move the hand straight {MOVES[len(moves)]} and hold it still.")
    raise CalibrationError(
        f"{len(moves)} of {len(MOVES)} moves within {MOVES_TIMEOUT_S:g} s: is the tracker running? "
        "`comanip monitor` shows HandPose"
    )


def _print(result: Calibration) -> None:
    out = console()
    vector = result.rotation_vector
    off = ", ".join(f"{name} {angle:.1f}" for name, angle in zip(MOVES, result.residual_deg))
    out.print(
        f"rotation vector {' '.join(f'{value:.4f}' for value in vector)} rad, "
        f"standard error {result.standard_error_deg:.1f} degrees"
    )
    out.print(f"degrees between each move and its axis: {off}")


@takes_bus
def calibrate(
    from_: Annotated[
        Path | None,
        typer.Option(
            "--from", help="A log (.log, .log.gz, .log.xz, .asc, .blf, .trc) or a recording (.csv) instead of the bus."
        ),
    ] = None,
    write: Annotated[
        bool, typer.Option("--set", help="Write the parameters instead of printing `param set` commands.")
    ] = False,
    *,
    address: BusAddress,
) -> None:
    """Estimate the tracker's rotation (q_Tv^E) from three moves of the hand: forward, left, up, with rests between.

    Forward, left and up are the x, y and z axes of the robot's torso. Each move starts where the previous one ended.
    Fails if the moves do not determine the rotation to within 5 degrees.
    """
    if from_ is not None:
        is_recording = from_.suffix.lower() == ".csv"
        result = solve(found_moves(recorded_samples(from_) if is_recording else hand_samples(logs.read(from_))))
    else:
        with open_bus(address) as bus:
            result = solve(_guide(bus))
    _print(result)
    values = [float(value) for value in result.rotation_vector]
    if not write:
        for name, value in zip(PARAMETERS, values):
            console().print(f"comanip param set {name} -- {value:.5f}")
        return
    with open_bus(address) as bus:
        client = OperatorClient(bus)
        for name, value in zip(PARAMETERS, values):
            client.write(name, value)
    console().print("written, and read back from the firmware unchanged")
