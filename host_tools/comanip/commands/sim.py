"""``comanip sim``: runs the simulator that `make build` built."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import typer

from comanip.commands.options import examples
from comanip.errors import ToolError

BUILT = Path("build") / "host" / "comanip-sim"
HELP = examples(
    "comanip sim --scenario pour --out out/pour",
    "comanip sim --scenario teleop --seed 7 --tracker hand.csv --out out/mine",
    "comanip sim -- --help          all options of the simulator",
)


def find_simulator() -> Path | None:
    """Searches for the simulator in this repository, in the working folder and the folders above it, and in PATH."""
    roots = [Path(__file__).resolve().parents[3], Path.cwd(), *Path.cwd().parents]
    built = [root / BUILT for root in roots if (root / BUILT).is_file()]
    found = shutil.which("comanip-sim")
    return built[0] if built else Path(found) if found else None


def sim(context: typer.Context) -> None:
    """Run the simulator of person, arm and bus. All options are passed to the simulator."""
    simulator = find_simulator()
    if simulator is None:
        raise ToolError(
            f"there is no {BUILT} in or above {Path.cwd()}, nor comanip-sim in PATH: "
            "run `make build` in a clone of the repository"
        )
    os.execv(simulator, [str(simulator), *context.args])
