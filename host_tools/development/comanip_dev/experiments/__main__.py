"""The paper's three experiments and the two further tasks of its Fig. 1, for many seeds and on recordings, headless.

``python -m comanip_dev.experiments --seeds 20 --out DIR`` prints one table and writes DIR/experiments.json (each run's
verdict and checks), DIR/laws.json, DIR/laws.md (our law beside the paper's own) and DIR/conditions.json (what is judged
over all seeds of a condition together). Exit status: 0 all runs and conditions with our law passed, 1 one failed, 2 wrong
use, 130 interrupted; after 2 and 130 none of these files is written. Finished runs stay in DIR: started again, a campaign
repeats only those whose program, scenario, recording or options have changed.
"""

from __future__ import annotations

import argparse
import json
import signal
import statistics
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from comanip_dev import REPOSITORY
from comanip_dev.experiments.campaign import (
    SIMULATOR,
    CampaignError,
    Job,
    Outcome,
    inputs_digests,
    recall,
    remember,
    require_simulator,
    run_jobs,
)
from comanip_dev.experiments.paper_gains import PAPER_GAINS

SCENARIOS = ("pour", "teleop", "mirror", "handover", "crank")
RECORDINGS_FOLDER = REPOSITORY.parent / "shared" / "data" / "hand_motion"
RECORDING_SEEDS = (1, 2, 3)
LAW_SEEDS = 5
CAUGHT_TOGETHER_MIN_PERCENT = 95.0  # of the particles that left the robot's glass, over all seeds of a condition
RESULT_FILES = ("experiments.json", "laws.json", "laws.md", "conditions.json")
FILE_COLUMNS = 120
BULKY_FILES = ("bus.log", "trace.csv")


@dataclass(frozen=True)
class Recording:
    """A recorded motion of the tracked person; `second` moves the other one."""

    scenario: str
    file: str
    reason: str
    second: str | None = None


# How far each is scaled into the arm's reach stands in the scenario, and in each run's summary.
RECORDINGS = (
    Recording("pour", "kul_pour1_com.csv", "a person pours: the motion of the very task"),
    Recording("pour", "kul_pour2_com.csv", "the same with a longer way; every sample is logged twice"),
    Recording("pour", "cmu_13_08_rhand.csv", "unscrews a cap and drinks: a vessel in the hand, other axes"),
    Recording("teleop", "ethz_handheld1.csv", "an object led freely in all six directions: teleoperation in kind"),
    Recording("teleop", "dfki_pillow_grasp.csv", "repeated reach and grasp"),
    Recording(
        "teleop",
        "kth_ho_sample_giver.csv",
        "giver and taker of one handover move both people",
        second="kth_ho_sample_taker.csv",
    ),
    Recording("handover", "kth_ho_sample_taker.csv", "a person takes a baton from another: here from the robot"),
    Recording("handover", "kth_ho_p1s1h2_taker.csv", "another taker, with glitches of 20 mm near the contact"),
    Recording("handover", "kth_ho_sample_taker_raw.csv", "the first with the 8 % of lost samples left out"),
)


@dataclass(frozen=True)
class Figure:
    """A check whose value tells how well it went; `higher_is_better` says which extreme is the worst."""

    check: str
    higher_is_better: bool

    def worst(self, values: Sequence[float]) -> float:
        return min(values) if self.higher_is_better else max(values)


DECISIVE = {
    "pour": (Figure("glass_tilt", True), Figure("water_poured", True), Figure("water_caught", True)),
    "teleop": (Figure("pipe_with_taker", True), Figure("pipe_drops", False)),
    "mirror": (
        Figure("mirrored_back", False),
        Figure("same_side", False),
        Figure("same_height", False),
        Figure("carried_for", True),
        Figure("force_rms", False),
        Figure("force_peak", False),
        Figure("relation", False),
        Figure("following", False),
    ),
    "handover": (Figure("baton_with_person", True), Figure("baton_drops", False)),
    "crank": (Figure("turns", True), Figure("force_rms", False)),
}


# ---- what runs


def seed_jobs(seeds: int, out: Path) -> list[Job]:
    return [Job(name, seed, out / name / f"seed-{seed:02d}") for name in SCENARIOS for seed in range(1, seeds + 1)]


def recording_jobs(folder: Path, out: Path) -> list[Job]:
    """A file that the folder lacks is refused: a shorter list must not look like the whole one."""
    missing = sorted({r.file for r in RECORDINGS if not (folder / r.file).is_file()})
    missing += sorted({r.second for r in RECORDINGS if r.second and not (folder / r.second).is_file()} - set(missing))
    if missing:
        raise CampaignError(f"{folder}: lacks {', '.join(missing)}")
    return [
        Job(
            r.scenario,
            seed,
            out / r.scenario / f"recording-{Path(r.file).stem}-seed-{seed:02d}",
            folder / r.file,
            folder / r.second if r.second else None,
        )
        for r in RECORDINGS
        for seed in RECORDING_SEEDS
    ]


def paper_law_jobs(seeds: int, out: Path) -> list[Job]:
    return [
        Job(name, seed, out / name / f"paper-law-seed-{seed:02d}", parameters=PAPER_GAINS, arguments=("--paper-law",))
        for name in SCENARIOS
        for seed in range(1, min(seeds, LAW_SEEDS) + 1)
    ]


# ---- what came of it


def record(outcome: Outcome) -> dict:
    """One element of experiments.json."""
    job = outcome.job
    return {
        "scenario": job.scenario,
        "seed": job.seed,
        "recording": job.recording.name if job.recording else None,
        "result": outcome.result,
        "reason": outcome.reason,
        "checks": outcome.checks,
    }


@dataclass(frozen=True)
class Condition:
    """A scenario with its built-in motion or one recording, over all its seeds. In a single run of `pour` some 60 of 160
    particles leave the glass: 5 % of them are three, and chance decides. Together they are enough to be judged."""

    scenario: str
    recording: str | None
    outcomes: tuple[Outcome, ...]

    @property
    def label(self) -> str:
        played = f", {self.recording}" if self.recording else ""
        return f"{self.scenario}{played}, {len(self.outcomes)} seeds together"

    def _particles(self, key: str) -> int:
        return sum((o.summary.get("water") or {}).get(key, 0) for o in self.outcomes)

    @property
    def poured(self) -> int:
        return self._particles("poured")

    @property
    def caught(self) -> int:
        return self._particles("in_person_cup")

    @property
    def caught_percent(self) -> float | None:
        return 100.0 * self.caught / self.poured if self.poured else None

    @property
    def passed(self) -> bool:
        return self.caught_percent is not None and self.caught_percent >= CAUGHT_TOGETHER_MIN_PERCENT

    @property
    def reason(self) -> str:
        """Why it failed."""
        return (
            f"{self.caught} of {self.poured} particles caught ({_shown(self.caught_percent)} %), "
            f"expected at least {CAUGHT_TOGETHER_MIN_PERCENT:g} %"
        )

    def record(self) -> dict:
        """One element of conditions.json."""
        return {
            "scenario": self.scenario,
            "recording": self.recording,
            "runs": len(self.outcomes),
            "poured": self.poured,
            "caught": self.caught,
            "caught_percent": self.caught_percent,
            "limit_percent": CAUGHT_TOGETHER_MIN_PERCENT,
            "pass": self.passed,
        }


def pouring_conditions(outcomes: Sequence[Outcome]) -> list[Condition]:
    found: dict[str | None, list[Outcome]] = {}
    for outcome in outcomes:
        if outcome.job.scenario == "pour":
            found.setdefault(outcome.job.recording.name if outcome.job.recording else None, []).append(outcome)
    return [Condition("pour", recording, tuple(part)) for recording, part in found.items()]


def _shown(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"


def figure_lines(outcomes: Sequence[Outcome], figures: Sequence[Figure]) -> list[tuple[str, str, str, str]]:
    """(name with unit, median, worst, limit) per figure over the runs that measured it; "-" where none did."""
    lines = []
    for figure in figures:
        found = [check for o in outcomes for check in o.checks if check["name"] == figure.check]
        values = [check["value"] for check in found if check["value"] is not None]
        unit = f" [{found[0]['unit']}]" if found and found[0]["unit"] else ""
        missing = f" ({len(outcomes) - len(values)} not measured)" if len(values) < len(outcomes) else ""
        limit = f"{'>=' if figure.higher_is_better else '<='} {found[0]['limit']:g}" if found else "-"
        median = statistics.median(values) if values else None
        worst = figure.worst(values) if values else None
        lines.append((figure.check + unit + missing, _shown(median), _shown(worst), limit))
    return lines


def condition_lines(conditions: Sequence[Condition]) -> list[tuple[str, str, str, str]]:
    """As figure_lines(): over the conditions in place of the runs."""
    if not conditions:
        return []
    values = [c.caught_percent for c in conditions if c.caught_percent is not None]
    median, worst = (statistics.median(values), min(values)) if values else (None, None)
    return [("water_caught, seeds together [%]", _shown(median), _shown(worst), f">= {CAUGHT_TOGETHER_MIN_PERCENT:g}")]


def _table_row(table: Table, title: str, outcomes: Sequence[Outcome], figures: Sequence[Figure]) -> None:
    passed = sum(o.passed for o in outcomes)
    conditions = pouring_conditions(outcomes)
    columns = zip(*figure_lines(outcomes, figures), *condition_lines(conditions), strict=True)
    style = "green" if passed == len(outcomes) and all(c.passed for c in conditions) else "red"
    table.add_row(title, Text(f"{passed}/{len(outcomes)}", style), *(Text("\n".join(column)) for column in columns))


def results_table(outcomes: Sequence[Outcome], recordings_missing: str | None) -> Table:
    table = Table(title="Experiments", caption=recordings_missing)
    for heading in ("scenario", "passed", "figure", "median", "worst", "limit"):
        justify = "right" if heading in ("passed", "median", "worst") else "left"
        table.add_column(heading, justify=justify, no_wrap=True)
    for name in SCENARIOS:
        for title, is_recorded in ((name, False), (f"{name}, recordings", True)):
            part = [o for o in outcomes if o.job.scenario == name and (o.job.recording is not None) == is_recorded]
            if part:
                _table_row(table, title, part, DECISIVE[name])
                table.add_section()
    return table


# ---- the two laws


def _median(outcomes: Sequence[Outcome], read: Callable[[dict], float | None]) -> float | None:
    values = [value for o in outcomes if (value := read(o.summary)) is not None]
    return statistics.median(values) if values else None


def _tracking(key: str) -> Callable[[dict], float | None]:
    return lambda summary: (summary.get("tracking") or {}).get(key)


def _force(key: str) -> Callable[[dict], float | None]:
    """The largest of the people's."""

    def read(summary: dict) -> float | None:
        values = [person[key] for person in summary.get("people") or [] if person.get(key) is not None]
        return max(values) if values else None

    return read


def law_figures(outcomes: Sequence[Outcome]) -> dict:
    """Medians over the runs, and how many passed; null: no run measured it."""
    return {
        "runs": len(outcomes),
        "passed": sum(o.passed for o in outcomes),
        "rms_position_mm": _median(outcomes, _tracking("rms_position_mm")),
        "rms_orientation_deg": _median(outcomes, _tracking("rms_orientation_deg")),
        "force_rms_N": _median(outcomes, _force("force_rms_N")),
        "force_peak_N": _median(outcomes, _force("force_peak_N")),
    }


def compare_laws(ours: Sequence[Outcome], paper: Sequence[Outcome]) -> list[dict]:
    """Per scenario, both laws over the same seeds."""
    rows = []
    for name in SCENARIOS:
        theirs = [o for o in paper if o.job.scenario == name]
        seeds = {o.job.seed for o in theirs}
        same = [o for o in ours if o.job.scenario == name and o.job.recording is None and o.job.seed in seeds]
        rows.append({"scenario": name, "default": law_figures(same), "paper": law_figures(theirs)})
    return rows


def laws_markdown(rows: Sequence[dict]) -> str:
    gains = dict(PAPER_GAINS)
    lines = [
        "# The default law and the paper's own",
        "",
        f"Medians over {rows[0]['paper']['runs']} seeds. The paper's law: error in the torso's frame, W = 1, "
        f"K = diag({gains['gain_w_per_s']:g} x4, {gains['gain_dual_w_per_s']:g} x4)/s, lambda = {gains['damping']:g} "
        "(docs/gains.md). Force: at the person's hand; a dash: nothing was held or measured.",
        "",
        "| scenario | law | position RMS [mm] | orientation RMS [deg] | force RMS / peak [N] | success |",
        "|---|---|---|---|---|---|",
    ]
    for row in rows:
        for law in ("default", "paper"):
            f = row[law]
            force = f"{_shown(f['force_rms_N'])} / {_shown(f['force_peak_N'])}"
            lines.append(
                f"| {row['scenario']} | {law} | {_shown(f['rms_position_mm'])} | {_shown(f['rms_orientation_deg'])} "
                f"| {force} | {f['passed']} of {f['runs']} |"
            )
    return "\n".join(lines) + "\n"


# ---- the program


def _write(path: Path, text: str) -> None:
    """In one step: what is there is whole."""
    unfinished = path.with_name(path.name + ".part")
    unfinished.write_text(text)
    unfinished.replace(path)


def _drop_bulky_files(outcome: Outcome) -> None:
    for name in BULKY_FILES:
        (outcome.job.out / name).unlink(missing_ok=True)


def part_times(outcomes: Sequence[Outcome]) -> str:
    """What each part of the campaign took: the sum of its runs' wall times."""
    took_s: dict[str, float] = {}
    for outcome in outcomes:
        job = outcome.job
        part = "paper's law" if job.parameters else f"{job.scenario}, recordings" if job.recording else job.scenario
        took_s[part] = took_s.get(part, 0.0) + outcome.summary.get("wall_s", 0.0)
    return "runs took: " + "; ".join(f"{part} {seconds:.0f} s" for part, seconds in took_s.items())


def run_with_progress(
    jobs: Sequence[Job], simulator: Path, workers: int, console: Console, finish: Callable[[Outcome], None]
) -> list[Outcome]:
    """On a terminal a bar, elsewhere a line per run."""
    if not console.is_terminal:
        done = 0

        def tell(outcome: Outcome) -> None:
            nonlocal done
            done += 1
            finish(outcome)
            law = " (paper's law)" if outcome.job.parameters else ""
            print(f"{done}/{len(jobs)} {outcome.job.label}{law}: {outcome.result}", file=console.file, flush=True)

        return run_jobs(jobs, simulator, workers, tell)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console) as progress:
        task = progress.add_task("experiments", total=len(jobs))

        def advance(outcome: Outcome) -> None:
            finish(outcome)
            progress.update(task, advance=1, description=outcome.job.label)

        return run_jobs(jobs, simulator, workers, advance)


def run_what_is_left(jobs: Sequence[Job], arguments: argparse.Namespace, console: Console) -> list[Outcome]:
    """Outcomes in the order of the jobs. What an earlier campaign into this folder finished is not repeated."""
    require_simulator(arguments.simulator)
    digests = dict(zip(jobs, inputs_digests(jobs, arguments.simulator), strict=True))
    files = BULKY_FILES if arguments.keep else ()
    done = {job: outcome for job in jobs if (outcome := recall(job, digests[job], files)) is not None}
    if done:
        print(f"{len(done)} of {len(jobs)} runs are there already, with the same inputs", file=console.file, flush=True)

    def finish(outcome: Outcome) -> None:
        if not arguments.keep:
            _drop_bulky_files(outcome)
        remember(outcome, digests[outcome.job])

    left = [job for job in jobs if job not in done]
    done |= {o.job: o for o in run_with_progress(left, arguments.simulator, arguments.jobs, console, finish)}
    return [done[job] for job in jobs]


def run_experiments(arguments: argparse.Namespace, console: Console) -> int:
    out: Path = arguments.out
    out.mkdir(parents=True, exist_ok=True)
    for name in RESULT_FILES:
        (out / name).unlink(missing_ok=True)
    folder: Path = arguments.recordings
    missing = None if folder.is_dir() else f"recordings not run: there is no folder {folder}"
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


def positive_integer(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r}: expected a whole number of at least 1")
    return int(text)


def _parse(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="comanip_dev.experiments", description="Runs the five experiments, headless.")
    parser.add_argument("--seeds", type=positive_integer, default=20, help="runs 1..N of each scenario (default 20)")
    parser.add_argument("--out", type=Path, required=True, help="folder for the results")
    parser.add_argument("--recordings", type=Path, default=RECORDINGS_FOLDER, help="folder of recorded hand motions")
    parser.add_argument("--jobs", type=positive_integer, default=2, help="processes at a time (default 2)")
    parser.add_argument("--keep", action="store_true", help="keep each run's bus.log and trace.csv")
    parser.add_argument("--simulator", type=Path, default=SIMULATOR, help="the program to run")
    return parser.parse_args(argv)


def interrupt_on_sigterm() -> None:
    """Told to end, a program ends its children as after Ctrl-C."""

    def interrupt(signal_number: int, frame: object) -> None:
        raise KeyboardInterrupt

    signal.signal(signal.SIGTERM, interrupt)


def guarded(program: str, run: Callable[[], int], after_interruption: str = "") -> int:
    """What stops the program is one line and an exit status, no traceback."""
    interrupt_on_sigterm()
    try:
        return run()
    except KeyboardInterrupt:
        print(f"{program}: interrupted: results are incomplete and not written{after_interruption}", file=sys.stderr)
        return 130
    except (CampaignError, OSError) as error:
        print(f"{program}: {error}", file=sys.stderr)
        return 2


def console() -> Console:
    """As wide as the terminal; in a file, as wide as our lines."""
    return Console() if sys.stdout.isatty() else Console(width=FILE_COLUMNS)


def main(argv: Sequence[str] | None = None) -> int:
    arguments = _parse(argv)
    again = "; the same command goes on from here"
    return guarded("comanip_dev.experiments", lambda: run_experiments(arguments, console()), again)


if __name__ == "__main__":
    sys.exit(main())
