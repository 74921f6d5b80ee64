"""The golden logs: the frames that the firmware received and sent, from boot through start, latch or clutch to the
stop, in shortened versions of the five experiments, on both profiles. tests/test_golden.py replays them.

``make golden`` records new ones after a change of behaviour. The commit gives the reason, ``REVISION`` is raised, and
CHANGELOG.md gets a line "Golden logs, revision N: WHAT CHANGED".
"""

from __future__ import annotations

import argparse
import lzma
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from comanip.bus import logs
from comanip.bus.frame import messages

REVISION = 1

FOLDER = Path(__file__).resolve().parent
REPOSITORY = FOLDER.parents[1]
SCENES, EXPERIMENTS = FOLDER / "scenes", REPOSITORY / "sim" / "scenarios"
SIMULATOR = REPOSITORY / "build" / "host" / "comanip-sim"
PROFILES = ("fd", "classic")
MAX_BYTES = 12_000_000  # total size of all golden logs


@dataclass(frozen=True)
class Run:
    """A run whose golden logs are NAME-PROFILE.log.xz. shows: what the logs contain in addition to the start and the
    stop."""

    name: str
    scenario: Path
    options: tuple[str, ...]
    shows: str


RUNS = (
    Run("pour", SCENES / "pour.yaml", ("--clutch", "4"), "a custom task, a blend, a clutch"),
    Run("teleop", EXPERIMENTS / "teleop.yaml", (), "a guided hand, a pipe taken and handed over"),
    Run("teleop_gaps", EXPERIMENTS / "teleop.yaml", ("--gap", "4:0.3", "--dropout", "0.03", "--duration", "9"),
        "gaps: hold and return"),
    Run("mirror", SCENES / "mirror.yaml", (), "a latch, forces"),
    Run("handover", EXPERIMENTS / "handover.yaml", (), "a stop in motion"),
    Run("handover_without_prediction", EXPERIMENTS / "handover.yaml", ("--param", "prediction=0"),
        "parameters, the paper's loop"),
    Run("crank", SCENES / "crank.yaml", ("--clutch", "5"), "a closed chain, a clutch"),
)  # fmt: skip


def path_of(run: Run, profile: str) -> Path:
    return FOLDER / f"{run.name}-{profile}.log.xz"


def of_the_firmware(path: Path) -> Iterator[str]:
    """Returns the log lines of the frames that the firmware receives or sends."""
    ids = {m.frame_id for m in messages().values() if "Firmware" in (*m.senders, *m.receivers)}
    return (logs.candump_line(frame) + "\n" for frame in logs.read(path) if frame.frame_id in ids)


def record(run: Run, profile: str, simulator: Path) -> None:
    """Records a golden log. The simulator may exit with 1, a failed check of the scenario, because a golden log records
    the firmware's behaviour whether or not the scenario passes."""
    with tempfile.TemporaryDirectory() as folder:
        command = [
            simulator,
            "--scenario",
            run.scenario,
            "--profile",
            profile,
            "--out",
            folder,
            "--quiet",
            *run.options,
        ]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode not in (0, 1):
            raise SystemExit(
                f"make golden: {run.name}, {profile}: the simulator's exit status is {done.returncode}\n{done.stderr}"
            )
        text = "".join(of_the_firmware(Path(folder) / "bus.log"))
    path_of(run, profile).write_bytes(lzma.compress(text.encode(), preset=9 | lzma.PRESET_EXTREME))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--simulator", type=Path, default=SIMULATOR, help="path of comanip-sim, which records the logs")
    simulator = parser.parse_args().simulator
    jobs = [(run, profile) for run in RUNS for profile in PROFILES]
    with ThreadPoolExecutor(2) as pool:
        list(pool.map(lambda job: record(*job, simulator), jobs))
    total = sum(path_of(*job).stat().st_size for job in jobs)
    print(
        f"{len(jobs)} golden logs, {total / 1e6:.1f} MB of {MAX_BYTES / 1e6:.0f} MB "
        f"in {FOLDER.relative_to(REPOSITORY)}/"
    )
    return 0 if total < MAX_BYTES else 1


if __name__ == "__main__":
    sys.exit(main())
