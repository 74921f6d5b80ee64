"""Runs the paper's three experiments and two further tasks from its Fig. 1, with many seeds and on recordings.

``python -m comanip_dev.experiments --seeds 20 --out DIR`` prints one table and writes DIR/experiments.json (the verdict
and the checks of each run), DIR/laws.json and DIR/laws.md (a comparison of our control law with the paper's), and
DIR/conditions.json (the verdicts over all seeds of a condition). Exit status: 0 all runs and conditions with our law
passed, 1 a run or condition failed, 2 usage error, 130 interrupted. With exit status 2 or 130, none of these files is
written. Finished runs stay in DIR. A second run of the same command uses these results. It repeats only runs for which
the program, the scenario, the recording or the options have changed.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from comanip_dev.experiments.campaign import SIMULATOR
from comanip_dev.experiments.jobs import RECORDINGS_FOLDER, paper_law_jobs, recording_jobs, seed_jobs
from comanip_dev.experiments.judgement import pouring_conditions, record
from comanip_dev.experiments.laws import compare_laws, laws_markdown
from comanip_dev.experiments.program import console, guarded, positive_integer
from comanip_dev.experiments.runs import part_times, run_what_is_left
from comanip_dev.experiments.table import results_table

RESULT_FILES = ("experiments.json", "laws.json", "laws.md", "conditions.json")


def _write(path: Path, text: str) -> None:
    """Writes the file atomically."""
    unfinished = path.with_name(path.name + ".part")
    unfinished.write_text(text)
    unfinished.replace(path)


def run_experiments(arguments: argparse.Namespace, console: Console) -> int:
    out: Path = arguments.out
    out.mkdir(parents=True, exist_ok=True)
    for name in RESULT_FILES:
        (out / name).unlink(missing_ok=True)
    folder: Path = arguments.recordings
    missing = None if folder.is_dir() else f"recordings were not run: there is no folder {folder}"
    ours = seed_jobs(arguments.seeds, out) + (recording_jobs(folder, out) if missing is None else [])
    jobs = ours + paper_law_jobs(arguments.seeds, out)

    started_s = time.monotonic()
    outcomes = run_what_is_left(jobs, arguments, console)
    default, paper = outcomes[: len(ours)], outcomes[len(ours) :]
    laws = compare_laws(default, paper)
    conditions = pouring_conditions(default)
    _write(out / "experiments.json", json.dumps([record(o) for o in default], indent=1) + "\n")
    _write(out / "laws.json", json.dumps(laws, indent=1) + "\n")
    _write(out / "laws.md", laws_markdown(laws))
    _write(out / "conditions.json", json.dumps([c.record() for c in conditions], indent=1) + "\n")

    console.print(results_table(default, missing))
    failed = [o for o in default if not o.passed]
    for outcome in failed:
        print(f"FAILED {outcome.job.label}: {outcome.reason}", file=console.file)
    failed_conditions = [c for c in conditions if not c.passed]
    for condition in failed_conditions:
        print(f"FAILED {condition.label}: {condition.reason}", file=console.file)
    print(part_times(outcomes), file=console.file)
    print(
        f"{len(default) - len(failed)} of {len(default)} passed; {time.monotonic() - started_s:.0f} s; "
        f"wrote {', '.join(str(out / name) for name in RESULT_FILES)}",
        file=console.file,
    )
    return 1 if failed or failed_conditions else 0


def _parse(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="comanip_dev.experiments", description="Runs the five experiments, headless.")
    parser.add_argument("--seeds", type=positive_integer, default=20, help="number of seeds per scenario (default 20)")
    parser.add_argument("--out", type=Path, required=True, help="folder for the results")
    parser.add_argument("--recordings", type=Path, default=RECORDINGS_FOLDER, help="folder of recorded hand motions")
    parser.add_argument("--jobs", type=positive_integer, default=2, help="parallel simulators (default 2)")
    parser.add_argument("--keep", action="store_true", help="keep each run's bus.log and trace.csv")
    parser.add_argument("--simulator", type=Path, default=SIMULATOR, help="the simulator to run")
    return parser.parse_args(argv)


def main(argv: Sequence[str] | None = None) -> int:
    arguments = _parse(argv)
    again = "; run the same command again to continue"
    return guarded("comanip_dev.experiments", lambda: run_experiments(arguments, console()), again)


if __name__ == "__main__":
    sys.exit(main())
