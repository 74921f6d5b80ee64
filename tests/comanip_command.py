"""Runs ``comanip`` as a user would. If ``comanip`` and the test must share a python-can `virtual` bus, it runs in the
test's process instead."""

from __future__ import annotations

import subprocess
import sys

from simulation import PATIENCE_S, REPOSITORY

COMANIP = REPOSITORY / ".venv" / "bin" / "comanip"
WRONG_USE = 2


def call(*arguments: object, text: str | None = None, environment: dict | None = None) -> subprocess.CompletedProcess:
    """Runs ``comanip`` in its own process, with `text` as its standard input."""
    command = [str(COMANIP), *(str(argument) for argument in arguments)]
    return subprocess.run(
        command, input=text, capture_output=True, text=True, check=False, timeout=PATIENCE_S, env=environment
    )


def call_here(monkeypatch, capsys, *arguments: object) -> tuple[int, str, str]:
    """Runs ``comanip`` in this process. Returns its exit status, standard output and standard error."""
    from comanip.__main__ import main

    monkeypatch.setattr(sys, "argv", ["comanip", *(str(argument) for argument in arguments)])
    capsys.readouterr()
    try:
        main()
        status = 0
    except SystemExit as end:
        status = end.code or 0
    out, err = capsys.readouterr()
    return status, out, err


def require_refusal(done: subprocess.CompletedProcess, *words: str) -> None:
    """Checks that the command was refused with one error line that contains these words."""
    assert done.returncode == WRONG_USE, (done.stdout, done.stderr)
    assert done.stderr.startswith("comanip: ") and done.stderr.count("\n") == 1, done.stderr
    for word in words:
        assert word in done.stderr, done.stderr
