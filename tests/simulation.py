"""Runs the simulator as a user would: in its own process, with command-line options, and with its files in a folder of
the test."""

from __future__ import annotations

import functools
import hashlib
import json
import subprocess
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path

from once import lock

REPOSITORY = Path(__file__).resolve().parents[1]
SIMULATOR = REPOSITORY / "build" / "host" / "comanip-sim"
SCENARIOS = ("pour", "teleop", "mirror")  # in tests/scenarios: hand motions without objects
EXPERIMENTS = ("pour", "teleop", "mirror", "handover", "crank")  # in sim/scenarios
SHIPPED = tuple(sorted(path.stem for path in (REPOSITORY / "sim" / "scenarios").glob("*.yaml")))  # includes EXPERIMENTS
FILES = ("bus.log", "summary.json", "trace.csv")
EXIT_PASS, EXIT_CHECK_FAILED, EXIT_WRONG_USE, EXIT_INTERRUPTED = 0, 1, 2, 130
PATIENCE_S = 300  # maximum wall time of a run; an idle machine needs a fiftieth of it, a busy machine much more
# EVENTFUL: the options of a run that writes the parameters WRITTEN and then sends select, start, clutch, latch and
# stop. A tracker gap and lost samples cause holds, and the tracker's clock wraps.
WRITTEN = {"task_blend_s": 0.5, "motion_scale": 0.75}
EVENTFUL = (
    "--scenario", "mirror", "--duration", "13", "--clutch", "7", "--gap", "4:0.2", "--dropout", "0.02",
    "--tracker-clock", "4294000000", *(f"--param={name}={value}" for name, value in WRITTEN.items()),
)  # fmt: skip
SHORT = ("--scenario", "teleop", "--duration", 3)
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
    raise AssertionError(f"summary.json contains {text}, which is not JSON")


def _plain(arguments: list[str]) -> list[str]:
    """Replaces a name from SCENARIOS after ``--scenario`` by its file in tests/scenarios. Those files contain plain
    hand motions without objects, so that a test involves only the bus and the tracking. The files of the experiments
    are returned by ``experiment()``."""
    places = [i + 1 for i, argument in enumerate(arguments[:-1]) if argument == "--scenario"]
    for place in places:
        if arguments[place] in SCENARIOS:
            arguments[place] = str(REPOSITORY / "tests" / "scenarios" / f"{arguments[place]}_moves.yaml")
    return arguments


def experiment(name: str) -> Path:
    """Returns the scenario file of one of SHIPPED."""
    return REPOSITORY / "sim" / "scenarios" / f"{name}.yaml"


def call(
    *arguments: object, cwd: Path | None = None, environment: dict[str, str] | None = None
) -> subprocess.CompletedProcess:
    """Runs the simulator with these arguments, converted to text."""
    command = [str(SIMULATOR), *_plain([str(argument) for argument in arguments])]
    return subprocess.run(
        command, capture_output=True, text=True, check=False, timeout=PATIENCE_S, cwd=cwd, env=environment
    )


def run(out: Path, *arguments: object, cwd: Path | None = None, environment: dict[str, str] | None = None,
        quiet: bool = True) -> Run:  # fmt: skip
    """Runs the simulator with `out` as its output folder."""
    done = call("--out", out, *(["--quiet"] if quiet else []), *arguments, cwd=cwd, environment=environment)
    return Run(out, done.returncode, done.stdout, done.stderr)


@dataclass
class Shared:
    """The folder for the runs shared within this session. tests/conftest.py sets it before the first test."""

    folder: Path | None = None


SHARED = Shared()


@functools.cache
def _simulator_hash() -> bytes:
    return hashlib.sha256(SIMULATOR.read_bytes()).digest()


def _content(argument: str) -> bytes:
    return Path(argument).read_bytes() if Path(argument).is_file() else b""


def shared(*arguments: object) -> Run:
    """Does the same as run(), for tests that only read the files of the run. All tests and workers of a session share
    one run for each combination of program, command and input files."""
    command = _plain([str(argument) for argument in arguments])
    digest = hashlib.sha256(_simulator_hash())
    for argument in command:
        digest.update(f"{argument}\0".encode() + hashlib.sha256(_content(argument)).digest())
    out = SHARED.folder / digest.hexdigest()[:16]
    result = out.with_suffix(".json")
    with lock(out.with_suffix(".lock")):
        if not result.exists():
            done = run(out, *arguments)
            result.write_text(json.dumps({**asdict(done), "out": str(out)}))
    return Run(**{**json.loads(result.read_text()), "out": out})


def modes(run_: Run) -> list[tuple[str, str]]:
    return [(change["mode"], change["reason"]) for change in run_.summary["modes"]]


def recording_csv(*rows: str) -> str:
    """Returns the text of a recording with the given rows."""
    return "\n".join([RECORDING_HEADER, *rows]) + "\n"
