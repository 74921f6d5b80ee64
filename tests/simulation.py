"""Runs the simulator as a person does: its own process, its own options, its files in a folder of the test's."""

from __future__ import annotations

import json
import subprocess
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[1]
SIMULATOR = REPOSITORY / "build" / "host" / "comanip-sim"
SCENARIOS = ("pour", "teleop", "mirror")  # of tests/scenarios: the tasks without objects
EXPERIMENTS = ("pour", "teleop", "mirror", "handover", "crank")  # of sim/scenarios
FILES = ("bus.log", "summary.json", "trace.csv")
EXIT_PASS, EXIT_CHECK_FAILED, EXIT_WRONG_USE, EXIT_INTERRUPTED = 0, 1, 2, 130
TIMEOUT_S = 120
RECORDING_HEADER = "t_s,x_m,y_m,z_m,qw,qx,qy,qz"


@dataclass(frozen=True)
class Run:
    """A finished run."""

    out: Path
    status: int
    stdout: str
    stderr: str

    @property
    def log(self) -> Path:
        return self.out / "bus.log"

    @property
    def trace(self) -> Path:
        return self.out / "trace.csv"

    @cached_property
    def summary(self) -> dict:
        return json.loads((self.out / "summary.json").read_text(), parse_constant=_refuse_constant)

    def require_pass(self) -> Run:
        assert self.status == EXIT_PASS, f"exit status {self.status}: {self.stderr}{self.stdout}"
        return self


def _refuse_constant(text: str) -> None:
    raise AssertionError(f"summary.json holds {text}, which JSON does not know")


def _plain(arguments: list[str]) -> list[str]:
    """After ``--scenario``, one of SCENARIOS is the file of this name in tests/scenarios: plain motions of the hand, with
    nothing in it, so that a test sees the bus and the tracking alone. The experiments go by ``experiment()``."""
    places = [i + 1 for i, argument in enumerate(arguments[:-1]) if argument == "--scenario"]
    for place in places:
        if arguments[place] in SCENARIOS:
            arguments[place] = str(REPOSITORY / "tests" / "scenarios" / f"{arguments[place]}_moves.yaml")
    return arguments


def experiment(name: str) -> Path:
    """The file of one of the EXPERIMENTS."""
    return REPOSITORY / "sim" / "scenarios" / f"{name}.yaml"


def call(
    *arguments: object, cwd: Path | None = None, environment: dict[str, str] | None = None
) -> subprocess.CompletedProcess:
    """The simulator with these arguments, turned into text."""
    command = [str(SIMULATOR), *_plain([str(argument) for argument in arguments])]
    return subprocess.run(
        command, capture_output=True, text=True, check=False, timeout=TIMEOUT_S, cwd=cwd, env=environment
    )


def run(out: Path, *arguments: object, cwd: Path | None = None, environment: dict[str, str] | None = None,
        quiet: bool = True) -> Run:  # fmt: skip
    """A run into the folder `out`."""
    done = call("--out", out, *(["--quiet"] if quiet else []), *arguments, cwd=cwd, environment=environment)
    return Run(out, done.returncode, done.stdout, done.stderr)


def modes(run_: Run) -> list[tuple[str, str]]:
    return [(change["mode"], change["reason"]) for change in run_.summary["modes"]]


def recording_csv(*rows: str) -> str:
    """The text of a recording."""
    return "\n".join([RECORDING_HEADER, *rows]) + "\n"
