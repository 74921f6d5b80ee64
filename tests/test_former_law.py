"""Checks that the control law without prediction computes the same velocities, bit for bit, as before prediction was
added. Three sets of gains and weights are tested: the former defaults, the paper's, and a set of unequal values.

before_prediction.txt is the output of digest.c, compiled with the firmware of commit e544a9a, the last commit without
prediction.
"""

from __future__ import annotations

import subprocess
from pathlib import Path

HERE = Path(__file__).parent
REPOSITORY = HERE.parent
FLAGS = ["-std=c11", "-O2", "-ffp-contract=off", "-fno-math-errno", "-Wall", "-Wextra", "-Werror", "-Ibuild/generated"]


def test_the_velocities_without_prediction_are_unchanged(tmp_path):
    firmware = sorted((REPOSITORY / "firmware").rglob("*.c"))
    sources = [path for path in firmware if path.name != "main.c"]
    program = tmp_path / "digest"
    subprocess.run(
        ["gcc", *FLAGS, HERE / "former_law" / "digest.c", *sources, "build/generated/comanip_dbc.c", "-lm", "-o",
         program],
        cwd=REPOSITORY, check=True,
    )  # fmt: skip
    printed = subprocess.run([program], check=True, capture_output=True, text=True).stdout
    assert printed == (HERE / "former_law" / "before_prediction.txt").read_text()
