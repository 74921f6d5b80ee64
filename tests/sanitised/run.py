"""Runs the tests that use the compiled core against the sanitised one: ``run.py FOLDER RUNTIME [options of pytest]``.

FOLDER contains _core.abi3.so and rest/loop.so (sanitised.mk). RUNTIME is clang's runtime library. A sanitiser ends the
process in which it finds an error. A test that expects this process to fail would pass nevertheless. Sanitisers
therefore write their reports to files, and the run fails if there is any such file.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import core_users

HERE = Path(__file__).resolve().parent


def environment(folder: Path, runtime: str, reports: Path) -> dict[str, str]:
    """Returns the environment for the tests. PYTHONMALLOC=malloc allocates each Python object separately, so that the
    sanitiser detects an access past its end."""
    log = f"log_path={reports / 'report'}"
    return os.environ | {
        "COMANIP_SANITISED": str(folder),
        "PYTHONPATH": str(HERE),
        "PYTHONMALLOC": "malloc",
        "COMANIP_SANITISER_RUNTIME": runtime,
        "ASAN_OPTIONS": f"detect_leaks=0:{log}",
        "UBSAN_OPTIONS": f"print_stacktrace=1:{log}",
    }


def run(files: Sequence[Path], options: Sequence[str], folder: Path, runtime: str, reports: Path) -> int:
    """Runs pytest and prints what the sanitisers found. Returns pytest's exit status, or 1 if it is 0 but a sanitiser
    found an error."""
    shutil.rmtree(reports, ignore_errors=True)
    reports.mkdir(parents=True)
    command = [sys.executable, "-m", "pytest", *map(str, files), *options]
    status = subprocess.run(command, env=environment(folder, runtime, reports), check=False).returncode
    found = sorted(reports.iterdir())
    for report in found:
        print(f"{report}:\n{report.read_text()}", file=sys.stderr)
    if found:
        print(f"make test-sanitised: the sanitisers wrote {len(found)} reports (above), expected none", file=sys.stderr)
    return status or bool(found)


def main(folder: Path, runtime: str, options: Sequence[str]) -> int:
    files = [*core_users.test_files(), HERE / "sanitised_tests.py"]
    return run(files, options, folder, runtime, folder / "reports")


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]).resolve(), sys.argv[2], sys.argv[3:]))
