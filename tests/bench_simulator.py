"""Simulated time over wall time, for each scenario (`make bench`). The whole process counts, with its start and the
files it writes. Exits 1 if a median is below what was asked for."""

from __future__ import annotations

import os
import statistics
import sys
import tempfile
import time
from pathlib import Path

from simulation import SCENARIOS, run

RUNS = 9
DURATION_S = 60
LEAST = 25.0


def ratios(scenario: str) -> list[float]:
    """The first run, which warms the caches, is left out."""
    result = []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(1 + RUNS):
            start_s = time.perf_counter()
            run(Path(folder), "--scenario", scenario, "--duration", DURATION_S).require_pass()
            result.append(DURATION_S / (time.perf_counter() - start_s))
    return result[1:]


def main() -> int:
    print(f"simulated time over wall time: {RUNS} runs of {DURATION_S} s, {os.cpu_count()} cores, at least {LEAST:g}")
    print(f"{'scenario':<10} {'median':>8} {'least':>8} {'most':>8}")
    slow = False
    for scenario in SCENARIOS:
        measured = ratios(scenario)
        median = statistics.median(measured)
        slow = slow or median < LEAST
        verdict = "" if median >= LEAST else "  too slow"
        print(f"{scenario:<10} {median:8.1f} {min(measured):8.1f} {max(measured):8.1f}{verdict}")
    return int(slow)


if __name__ == "__main__":
    sys.exit(main())
