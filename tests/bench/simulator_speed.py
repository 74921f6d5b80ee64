"""Measures how much faster than real time the simulator runs, as a part of `make bench`.

The speed is the simulated time divided by the wall time of the simulator process, which includes its start and the
writing of files. Each scenario of tests/scenarios (hand motions without objects) and each of the five experiments has a
required speed.
"""

from __future__ import annotations

import os
import statistics
import tempfile
import time
from pathlib import Path

from simulation import EXPERIMENTS, SCENARIOS, experiment, run

RUNS = 9
DURATION_S = 60  # simulated duration of the scenarios without objects; experiments run to their end
# Required ratios of simulated time to wall time.
LEAST_PLAIN, LEAST_POUR, LEAST_EXPERIMENT = 25.0, 7.0, 15.0


def ratios(*arguments: object) -> list[float]:
    """Returns the ratio of simulated time to wall time for each run. The first run, which warms the caches, is left
    out."""
    result = []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(1 + RUNS):
            start_s = time.perf_counter()
            done = run(Path(folder), *arguments)
            wall_s = time.perf_counter() - start_s
            result.append(done.require_pass().summary["sim_s"] / wall_s)
    return result[1:]


def contenders() -> list[tuple[str, float, tuple[object, ...]]]:
    """Returns the name, required ratio and simulator options of each scenario."""
    plain = [(f"{name} (moves)", LEAST_PLAIN, ("--scenario", name, "--duration", DURATION_S)) for name in SCENARIOS]
    return plain + [
        (name, LEAST_POUR if name == "pour" else LEAST_EXPERIMENT, ("--scenario", experiment(name)))
        for name in EXPERIMENTS
    ]


def measure() -> tuple[dict[str, dict[str, float]], bool]:
    """Prints a table. Returns the median, smallest and largest ratio of each scenario, and whether any scenario misses
    its required ratio."""
    print(f"simulated time divided by wall time: {RUNS} runs of each scenario, {os.cpu_count()} cores")
    print(f"{'scenario':<16} {'required':>8} {'median':>8} {'least':>8} {'most':>8}")
    found, slow = {}, False
    for name, required, arguments in contenders():
        measured = ratios(*arguments)
        median = statistics.median(measured)
        found[name] = {"required": required, "median": median, "least": min(measured), "most": max(measured)}
        slow = slow or median < required
        verdict = "" if median >= required else "  too slow"
        print(f"{name:<16} {required:8g} {median:8.1f} {min(measured):8.1f} {max(measured):8.1f}{verdict}")
    return found, slow
