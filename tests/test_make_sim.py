"""`make` works as a user types it: `make help`, and `make sim` with the options that it passes to the simulator."""

from __future__ import annotations

import json
import os
import re
import subprocess

from images import MAKE_LOCK
from once import lock
from simulation import REPOSITORY, recording_csv

MAKES_OWN = ("MAKEFLAGS", "MFLAGS", "MAKELEVEL")  # set if make runs these tests


def make(*arguments: str) -> subprocess.CompletedProcess:
    environment = {name: value for name, value in os.environ.items() if name not in MAKES_OWN}
    command = ["make", "--no-print-directory", *arguments]
    with lock(MAKE_LOCK):
        return subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, check=False, env=environment)


def test_make_alone_prints_help():
    done = make()
    assert done.returncode == 0
    for target in ("sim", "test", "deps", "build", "bench", "target", "clean"):
        assert re.search(rf"^  make {target} ", done.stdout, re.MULTILINE), target


def test_make_sim_passes_everything_on(tmp_path):
    out = tmp_path / "a folder"
    recording = tmp_path / "a hand.csv"
    recording.write_text(recording_csv(*(f"{0.01 * i:.2f},{0.0001 * i:.4f},0,0,1,0,0,0" for i in range(100))))
    options = "--duration 4 --gap 3:0.1 --param trace=0 --quiet"
    done = make("sim", "SCENARIO=teleop", f"TRACKER={recording}", "SEED=9", f"OUT={out}", f"ARGS={options}")
    assert done.returncode == 0, done.stderr
    summary = json.loads((out / "summary.json").read_text())
    assert (summary["scenario"], summary["seed"], summary["sim_s"]) == ("teleop", 9, 4)
    assert summary["tracker"]["lost"] == 25
    assert make("sim", "SCENARIO=juggle", f"OUT={out}").returncode != 0
