"""Runs the simulator many times in a few processes, and reuses the results of earlier campaigns."""

from __future__ import annotations

import functools
import hashlib
import json
import subprocess
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

from comanip_dev import REPOSITORY

SIMULATOR = REPOSITORY / "build" / "host" / "comanip-sim"
SCENARIOS_FROM_SIMULATOR = "../../sim/scenarios"
INPUTS_FILE = "inputs.sha256"
RUN_TIMEOUT_S = 900.0
POLL_S = 0.01
END_S = 2.0  # time allowed for a simulator to end after SIGTERM


class CampaignError(Exception):
    """The campaign cannot be run. The message is one line that states the reason."""


@dataclass(frozen=True)
class Job:
    """One run of the simulator. parameters: parameters to write over the bus. arguments: further options for the
    simulator."""

    scenario: str
    seed: int
    out: Path
    recording: Path | None = None
    second_recording: Path | None = None
    parameters: tuple[tuple[str, float], ...] = ()
    arguments: tuple[str, ...] = ()

    @property
    def label(self) -> str:
        """The job's name in messages: "pour, seed 7" or "pour, kul_pour1_com.csv, seed 2"."""
        played = f", {self.recording.name}" if self.recording else ""
        return f"{self.scenario}{played}, seed {self.seed}"

    def command(self, simulator: Path) -> list[str]:
        command = [str(simulator), "--scenario", self.scenario, "--seed", str(self.seed), "--out", str(self.out)]
        command += ["--quiet", *self.arguments]
        if self.recording:
            command += ["--tracker", str(self.recording)]
        if self.second_recording:
            command += ["--tracker-second", str(self.second_recording)]
        for name, value in self.parameters:
            command += ["--param", f"{name}={value:g}"]
        return command


@dataclass(frozen=True)
class Outcome:
    """The outcome of a job. summary is empty if the run ended before the simulator judged it."""

    job: Job
    result: str  # "pass" or "fail", or "error" if there is no valid summary
    reason: str
    summary: dict = field(default_factory=dict)

    @property
    def passed(self) -> bool:
        return self.result == "pass"

    @property
    def checks(self) -> list[dict]:
        return self.summary.get("checks", [])


# ---- results of an earlier campaign


def inputs_digests(jobs: Sequence[Job], simulator: Path) -> list[str]:
    """Returns a digest for each job, over program, scenario, recordings and command line. Jobs with equal digests have
    equal results."""

    @functools.cache
    def content(path: Path) -> str:
        return hashlib.sha256(path.read_bytes()).hexdigest()

    def digest(job: Job) -> str:
        scenario = simulator.resolve().parent / SCENARIOS_FROM_SIMULATOR / f"{job.scenario}.yaml"
        files = [file for file in (scenario, job.recording, job.second_recording) if file and file.is_file()]
        command = [word for word in job.command(Path()) if word != str(job.out)]
        return hashlib.sha256("\n".join([*command, *map(content, [simulator, *files])]).encode()).hexdigest()

    return [digest(job) for job in jobs]


def remember(outcome: Outcome, digest: str) -> None:
    """Stores the digest of a run, so that later campaigns do not repeat the run. Does nothing if the result is
    "error"."""
    if outcome.result != "error":
        (outcome.job.out / INPUTS_FILE).write_text(digest + "\n")


def recall(job: Job, digest: str, files: Sequence[str]) -> Outcome | None:
    """Returns the outcome of an earlier run with this digest if its folder contains these files, otherwise None."""
    try:
        if (job.out / INPUTS_FILE).read_text().strip() != digest:
            return None
        summary = json.loads((job.out / "summary.json").read_text())
        outcome = Outcome(job, summary["result"], summary["reason"], summary)
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return outcome if all((job.out / file).is_file() for file in files) else None


# ---- running


@dataclass
class _Child:
    index: int
    process: subprocess.Popen
    stderr: IO[str]
    started_s: float


def _judge(job: Job, status: int, stderr: str) -> Outcome:
    """Returns the outcome with the verdict from the summary, or an error if the exit status contradicts the verdict."""
    last_line = stderr.strip().splitlines()[-1] if stderr.strip() else "no message"
    if status not in (0, 1):
        return Outcome(job, "error", f"exit status {status}: {last_line}")
    path = job.out / "summary.json"
    try:
        summary = json.loads(path.read_text())
        result, reason = summary["result"], summary["reason"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        return Outcome(job, "error", f"{path}: no summary ({error!r}); exit status {status}: {last_line}")
    if (result == "pass") != (status == 0):
        return Outcome(job, "error", f"{path}: result {result} contradicts exit status {status}", summary)
    return Outcome(job, result, reason, summary)


def _start(index: int, job: Job, simulator: Path) -> _Child:
    job.out.mkdir(parents=True, exist_ok=True)
    for name in (INPUTS_FILE, "summary.json"):  # an earlier run's files must not be taken for this run's
        (job.out / name).unlink(missing_ok=True)
    stderr = tempfile.TemporaryFile("w+")
    process = subprocess.Popen(job.command(simulator), stdout=subprocess.DEVNULL, stderr=stderr)
    return _Child(index, process, stderr, time.monotonic())


def _end(children: list[_Child]) -> None:
    for child in children:
        child.process.terminate()
    for child in children:
        try:
            child.process.wait(END_S)
        except subprocess.TimeoutExpired:
            child.process.kill()
            child.process.wait()
        child.stderr.close()


def _collect(child: _Child, job: Job, timeout_s: float) -> Outcome | None:
    """Returns the outcome if the simulator has ended, or None while it runs. Stops the simulator after timeout_s."""
    status = child.process.poll()
    if status is None:
        if time.monotonic() - child.started_s < timeout_s:
            return None
        _end([child])
        return Outcome(job, "error", f"stopped: not done after {timeout_s:g} s of wall time")
    child.stderr.seek(0)
    outcome = _judge(job, status, child.stderr.read())
    child.stderr.close()
    return outcome


def require_simulator(simulator: Path) -> None:
    if not simulator.is_file():
        raise CampaignError(f"{simulator}: there is no simulator: run `make build` first")


def run_jobs(
    jobs: Sequence[Job],
    simulator: Path = SIMULATOR,
    workers: int = 2,
    on_done: Callable[[Outcome], None] = lambda outcome: None,
    timeout_s: float = RUN_TIMEOUT_S,
) -> list[Outcome]:
    """Runs all jobs, `workers` at a time, and returns the outcomes in the order of the jobs. If interrupted, terminates
    the simulators."""
    require_simulator(simulator)
    outcomes: list[Outcome | None] = [None] * len(jobs)
    waiting = list(reversed(range(len(jobs))))
    running: list[_Child] = []
    try:
        while waiting or running:
            while waiting and len(running) < workers:
                index = waiting.pop()
                running.append(_start(index, jobs[index], simulator))
            for child in list(running):
                outcome = _collect(child, jobs[child.index], timeout_s)
                if outcome is not None:
                    running.remove(child)
                    outcomes[child.index] = outcome
                    on_done(outcome)
            time.sleep(POLL_S)
    finally:
        _end(running)
    return [outcome for outcome in outcomes if outcome is not None]
