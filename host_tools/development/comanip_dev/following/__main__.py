"""Measures how closely the end effector follows the person's hand, for various recordings, trackers and followers. A
follower is the firmware with one of three control laws, or another program.

``python -m comanip_dev.following --out DIR`` prints a table and the criteria, and writes DIR/following.json and
DIR/following.png. Results are stored in DIR/results.jsonl, so that an interrupted campaign can continue. Exit status: 0
if all criteria passed, or if nothing was measured because the default folder of recordings is missing; 1 if a criterion
failed; 2 for a usage error; 130 if interrupted.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

from rich.console import Console

from comanip_dev.experiments.campaign import SIMULATOR, CampaignError, Outcome, run_jobs
from comanip_dev.experiments.jobs import RECORDINGS_FOLDER
from comanip_dev.experiments.program import console, guarded, positive_integer
from comanip_dev.following import ode, plan, report
from comanip_dev.following.arm_model import ArmModel
from comanip_dev.following.case import BEGIN_S
from comanip_dev.following.cases import ARM, FULL, QUICK, Case, Choice, all_cases, measure, prepare, recordings
from comanip_dev.following.criteria import Judge
from comanip_dev.following.loop import LoopError
from comanip_dev.following.picture import plot
from comanip_dev.following.plan import Setting
from comanip_dev.following.recorded_hand import RecordingError, read
from comanip_dev.following.results import Results, fingerprint, scene_key

PRINT_EVERY_S = 10.0


class Progress:
    """Prints the progress about every PRINT_EVERY_S seconds and at the end."""

    def __init__(self, what: str, count: int) -> None:
        self._what, self._count, self._done, self._printed_s = what, count, 0, time.monotonic()

    def step(self) -> None:
        self._done += 1
        if self._done == self._count or time.monotonic() - self._printed_s > PRINT_EVERY_S:
            self._printed_s = time.monotonic()
            print(f"{self._what}: {self._done}/{self._count}", flush=True)


@contextlib.contextmanager
def _sigint_blocked() -> Iterator[None]:
    """Blocks SIGINT in this thread. Processes that are started meanwhile inherit the block, so that Ctrl-C interrupts
    only this process."""
    former = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, former)


def _in_processes(results: Results, work: Iterable[tuple], workers: int, what: str) -> None:
    """Calls each (function, argument, ...) in `work` in a worker process and stores the (key, value) that
    the function returns."""
    work = list(work)
    progress = Progress(what, len(work))
    # Workers are spawned, because a forked worker would hang if another thread held a lock, such as the allocator's, at
    # the moment of the fork.
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, spawn) as pool:
        try:
            with _sigint_blocked():
                pending = [pool.submit(*item) for item in work]
            for done in as_completed(pending):
                results.add(*done.result())
                progress.step()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _prepare(results: Results, paths: Sequence[Path], workers: int) -> dict[Setting, list[tuple[Path, float]]]:
    """Returns for each setting the recordings that the arm can follow, with their scales."""
    pairs = [(setting, path) for setting in plan.SETTINGS for path in paths]
    missing = [(prepare, *pair) for pair in pairs if scene_key(pair[0], pair[1].stem) not in results.values]
    _in_processes(results, missing, workers, "optima")
    scenes: dict[Setting, list[tuple[Path, float]]] = {setting: [] for setting in plan.SETTINGS}
    for setting, path in pairs:
        found = results.values[scene_key(setting, path.stem)]
        if found["followable"]:
            scenes[setting].append((path, found["position_scale"]))
    return scenes


def _in_ode(results: Results, cases: Sequence[Case], folder: Path, simulator: Path, workers: int) -> None:
    arm = ArmModel(ARM)
    progress = Progress("ODE", len(cases))
    by_folder = {folder / f"{number:04d}": case for number, case in enumerate(cases)}
    jobs = [
        ode.job(out, c.follower, c.condition, c.setting, c.recording, c.position_scale, c.seed)
        for out, c in by_folder.items()
    ]

    def finish(outcome: Outcome) -> None:
        case = by_folder[outcome.job.out]
        try:
            if case.recording is None:
                value = {"noise_um": ode.noise_um(arm, outcome)}
            else:
                value = ode.judge(arm, case.setting.task, outcome, BEGIN_S + read(case.recording).duration_s).as_dict()
        except (LoopError, OSError) as error:
            value = {"error": f"{error} ({outcome.reason})"}
        for name in ("trace.csv", "bus.log"):
            (outcome.job.out / name).unlink(missing_ok=True)
        results.add(case.key, value)
        progress.step()

    run_jobs(jobs, simulator, workers, finish)


def _left_out(results: Results, paths: Sequence[Path], unseen: dict[str, str]) -> dict[str, str]:
    reasons = dict(unseen)
    for path in paths:
        settings = []
        for setting in plan.SETTINGS:
            found = results.values[scene_key(setting, path.stem)]
            if not found["followable"]:
                settings.append(f"{setting.label}: {found['rms_mm']:.2f} mm")
        if settings:
            reasons[path.stem] = f"the arm's limits allow no error below 0.5 mm in {'; '.join(settings)}"
    return reasons


def _report(
    results: Results, choice: Choice, scenes: dict, left_out: dict[str, str], out: Path, terminal: Console
) -> bool:
    judge = Judge(results, {setting: [path.stem for path, _ in found] for setting, found in scenes.items()})
    entries = report.rows(judge, choice.conditions, choice.has_peers)
    criteria = [c for loop in (plan.LOOP, plan.ODE) for c in judge.criteria(loop)]
    knows_wrong = set(plan.WRONG) <= set(choice.conditions)
    criteria += judge.wrong_latency() if knows_wrong else []
    scales = {s.label: {path.stem: scale for path, scale in found} for s, found in scenes.items()}
    document = report.document(entries, criteria, scales, left_out, report.cases(results))
    text = json.dumps(document, indent=1) + "\n"
    (out / "following.json").write_text(text)
    in_loop = [entry for entry in entries if entry["loop"] == plan.LOOP and entry["setting"] == plan.TELEOP.label]
    attributes = {"rate [Hz]": "rate_hz", "latency [ms]": "latency_ms", "noise [mm]": "noise_mm"}
    sweeps = {name: [(getattr(c, attributes[name]), c.label) for c in swept] for name, swept in plan.SWEEPS.items()}
    plot(in_loop, sweeps, [condition.label for condition in plan.JUDGED], out / "following.png")
    terminal.print(report.table(entries))
    for name, reason in sorted(left_out.items()):
        print(f"left out: {name}: {reason}")
    for line in report.wrong_latency_lines(judge) if knows_wrong else []:
        print(line)
    terminal.print(report.criteria_table(criteria))
    failed = [c for c in criteria if not c.passed]
    print(
        f"{len(criteria) - len(failed)} of {len(criteria)} criteria passed; wrote {out}/following.json, following.png"
    )
    return not failed


def run(arguments: argparse.Namespace) -> int:
    folder: Path = arguments.recordings
    if not folder.is_dir() and folder != RECORDINGS_FOLDER:
        raise CampaignError(f"{folder}: no such folder: expected a folder of recordings (docs/recordings.md)")
    if not folder.is_dir():
        print(
            f"comanip_dev.following: skipped: there is no folder {folder} of recordings (docs/recordings.md); "
            "choose another one with --recordings"
        )
        return 0
    paths, unseen = recordings(folder)
    if not paths:
        raise CampaignError(f"{folder}: no recordings: expected CSV files as in docs/recordings.md")
    choice = QUICK if arguments.quick else FULL
    if arguments.quick:
        known = [path for path in paths if path.stem in plan.QUICK_RECORDINGS]
        paths, unseen = known or paths[: len(plan.QUICK_RECORDINGS)], {}
    arguments.out.mkdir(parents=True, exist_ok=True)
    results = Results.open(arguments.out / "results.jsonl", fingerprint(arguments.simulator))
    try:
        scenes = _prepare(results, paths, arguments.jobs)
    except RecordingError as error:
        raise CampaignError(str(error)) from None
    cases = [case for case in all_cases(choice, scenes) if case.key not in results.values]
    in_loop = [(measure, case) for case in cases if case.loop == plan.LOOP]
    _in_processes(results, in_loop, arguments.jobs, "loop")
    in_ode = [case for case in cases if case.loop == plan.ODE]
    _in_ode(results, in_ode, arguments.out / "ode", arguments.simulator, arguments.jobs)
    passed = _report(results, choice, scenes, _left_out(results, paths, unseen), arguments.out, console())
    return 0 if passed else 1


def _parse(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="comanip_dev.following", description="Measures how closely the robot follows a recorded hand."
    )
    parser.add_argument("--out", type=Path, required=True, help="folder for the results")
    parser.add_argument("--recordings", type=Path, default=RECORDINGS_FOLDER, help="folder of recorded hand motions")
    parser.add_argument(
        "--quick", action="store_true", help="measure only four recordings, the judged conditions and the firmware"
    )
    parser.add_argument(
        "--jobs", type=positive_integer, default=min(2, os.cpu_count() or 1), help="parallel processes (default 2)"
    )
    parser.add_argument("--simulator", type=Path, default=SIMULATOR, help="the simulator to run")
    return parser.parse_args(argv)


def main(argv: Sequence[str] | None = None) -> int:
    arguments = _parse(argv)
    again = "; measured results are kept: run the same command again to continue"
    return guarded("comanip_dev.following", lambda: run(arguments), again)


if __name__ == "__main__":
    sys.exit(main())
