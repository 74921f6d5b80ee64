"""Prints how closely the firmware follows each of the given recordings under one condition.

``python -m comanip_dev.following.one RECORDING.csv --set motion_scale=0.5``
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from comanip_dev.following import plan
from comanip_dev.following.arm_model import ArmModel
from comanip_dev.following.case import START_DEG, Scene, follow, noise_at_rest_um
from comanip_dev.following.followers import PARAMETERS, firmware
from comanip_dev.following.loop import LoopError
from comanip_dev.following.recorded_hand import RecordingError, read
from comanip_dev.following.scale import SHARE, largest_scale
from comanip_dev.following.tracker import Tracker


def _assignment(text: str) -> tuple[str, float]:
    name, equals, value = text.partition("=")
    try:
        if not equals:
            raise ValueError
        return name, float(value)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}': expected NAME=NUMBER, a parameter of the firmware") from None


def _within(low: float, high: float):
    """Returns an argparse type for numbers in this range."""

    def parse(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = float("nan")
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"'{text}': expected a number from {low:g} to {high:g}")
        return value

    return parse


def _parse(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="comanip_dev.following.one", description=__doc__)
    parser.add_argument("recordings", nargs="+", type=Path, help="CSV files as in docs/recordings.md")
    parser.add_argument("--set", dest="parameters", nargs="+", type=_assignment, default=[], metavar="NAME=VALUE")
    parser.add_argument("--paper-law", action="store_true", help="use the paper's control law with its best gains")
    parser.add_argument("--task", choices=sorted(START_DEG), default="teleop")
    parser.add_argument("--rate-hz", type=_within(15, 1000), default=250.0)
    parser.add_argument("--latency-ms", type=_within(0, 500), default=4.0)
    parser.add_argument("--noise-mm", type=_within(0, 100), default=0.05)
    parser.add_argument(
        "--announced-error-ms", type=_within(-500, 500), default=0.0, help="the announced latency minus the true one"
    )
    parser.add_argument("--rotation-scale", type=_within(0, 1), default=0.3)
    parser.add_argument(
        "--position-scale", type=_within(0, 10), help=f"default: {SHARE:g} times the largest scale in reach"
    )
    parser.add_argument("--seed", type=int, default=1)
    return parser.parse_args(argv)


def run(arguments: argparse.Namespace) -> None:
    arm = ArmModel("hoap3_right")
    tracker = Tracker(
        arguments.rate_hz,
        1e-3 * arguments.latency_ms,
        1e-3 * arguments.noise_mm,
        1e-3 * arguments.announced_error_ms,
        arguments.seed,
    )
    follower = firmware({**(PARAMETERS[plan.PAPER] if arguments.paper_law else {}), **dict(arguments.parameters)})
    recordings = [read(path) for path in arguments.recordings]
    print(f"noise at rest {noise_at_rest_um(arm, arguments.task, tracker, follower):.1f} um")
    print(
        f"{'recording':<26}{'scale':>8}{'RMS':>8}{'max mm':>8}{'deg':>7}{'delay ms':>10}{'acc m/s2':>10}{'limit %':>9}"
    )
    for recording in recordings:
        scale = arguments.position_scale
        if scale is None:
            start_rad = np.radians(START_DEG[arguments.task])
            scale = SHARE * largest_scale(arm, arguments.task, start_rad, recording, arguments.rotation_scale)
        f = follow(arm, Scene(recording, arguments.task, scale, arguments.rotation_scale), tracker, follower)
        print(
            f"{recording.name:<26}{scale:8.4f}{f.rms_mm:8.3f}{f.max_mm:8.2f}{f.rms_deg:7.1f}{f.delay_ms:10.1f}"
            f"{f.acceleration_mps2:10.2f}{f.limit_percent:9.2f}",
            flush=True,
        )


def main(argv: list[str] | None = None) -> int:
    try:
        run(_parse(argv))
    except OSError as error:
        print(f"comanip_dev.following.one: {error.filename}: {error.strerror}", file=sys.stderr)
        return 2
    except (LoopError, RecordingError) as error:
        print(f"comanip_dev.following.one: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
