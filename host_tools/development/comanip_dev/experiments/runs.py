"""Runs the jobs that an earlier campaign has not finished, and shows progress."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from comanip_dev.experiments.campaign import (
    Job,
    Outcome,
    inputs_digests,
    recall,
    remember,
    require_simulator,
    run_jobs,
)

BULKY_FILES = ("bus.log", "trace.csv")


def _drop_bulky_files(outcome: Outcome) -> None:
    for name in BULKY_FILES:
        (outcome.job.out / name).unlink(missing_ok=True)


def part_times(outcomes: Sequence[Outcome]) -> str:
    """Formats the total wall time of the runs in each part of the campaign."""
    took_s: dict[str, float] = {}
    for outcome in outcomes:
        job = outcome.job
        part = "paper's law" if job.parameters else f"{job.scenario}, recordings" if job.recording else job.scenario
        took_s[part] = took_s.get(part, 0.0) + outcome.summary.get("wall_s", 0.0)
    return "runs took: " + "; ".join(f"{part} {seconds:.0f} s" for part, seconds in took_s.items())


def run_with_progress(
    jobs: Sequence[Job], simulator: Path, workers: int, console: Console, finish: Callable[[Outcome], None]
) -> list[Outcome]:
    """Runs the jobs. On a terminal, shows a progress bar; otherwise, prints one line per run."""
    if not console.is_terminal:
        done = 0

        def print_line(outcome: Outcome) -> None:
            nonlocal done
            done += 1
            finish(outcome)
            law = " (paper's law)" if outcome.job.parameters else ""
            print(f"{done}/{len(jobs)} {outcome.job.label}{law}: {outcome.result}", file=console.file, flush=True)

        return run_jobs(jobs, simulator, workers, print_line)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console) as progress:
        task = progress.add_task("experiments", total=len(jobs))

        def advance(outcome: Outcome) -> None:
            finish(outcome)
            progress.update(task, advance=1, description=outcome.job.label)

        return run_jobs(jobs, simulator, workers, advance)


def run_what_is_left(jobs: Sequence[Job], arguments: argparse.Namespace, console: Console) -> list[Outcome]:
    """Runs the jobs that an earlier campaign has not finished. Returns all outcomes in the order of the jobs."""
    require_simulator(arguments.simulator)
    digests = dict(zip(jobs, inputs_digests(jobs, arguments.simulator), strict=True))
    files = BULKY_FILES if arguments.keep else ()
    done = {job: outcome for job in jobs if (outcome := recall(job, digests[job], files)) is not None}
    if done:
        print(
            f"{len(done)} of {len(jobs)} runs are already finished with the same inputs", file=console.file, flush=True
        )

    def finish(outcome: Outcome) -> None:
        if not arguments.keep:
            _drop_bulky_files(outcome)
        remember(outcome, digests[outcome.job])

    left = [job for job in jobs if job not in done]
    done |= {o.job: o for o in run_with_progress(left, arguments.simulator, arguments.jobs, console, finish)}
    return [done[job] for job in jobs]
