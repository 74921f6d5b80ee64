"""``comanip decode``: prints frames as text."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from comanip.bus import logs
from comanip.bus.frame import CLASSIC, E2EChecker, messages, signals_text
from comanip.commands.options import examples
from comanip.errors import ToolError

HELP = examples(
    "comanip decode out/pour/bus.log --only FirmwareStatus --only CommandAck",
    "candump vcan0 | comanip decode",
    "candump -L vcan0 | comanip decode -",
)


def decode(
    log: Annotated[
        Path,
        typer.Argument(
            help="A log (.log, .log.gz, .log.xz, .asc, .blf, .trc). By default, or with -, candump's lines from stdin."
        ),
    ] = Path("-"),
    only: Annotated[
        list[str] | None,
        typer.Option("--only", help="Print this message of the DBC only (in either profile); may be repeated."),
    ] = None,
) -> None:
    """Print each frame with its time, id, name, end-to-end verdict and decoded signals."""
    names = {message.name for message in messages().values()}
    for name in only or ():
        if name not in names:
            raise ToolError(f"--only '{name}': no such message, expected one of {', '.join(sorted(names))}")
    frames = logs.read_candump(sys.stdin, "standard input") if str(log) == "-" else logs.read(log)
    checker = E2EChecker()
    for frame in frames:
        verdict = checker.check(frame)
        if only and not {frame.name, frame.name.removeprefix(CLASSIC)} & set(only):
            continue
        kind = "error frame" if frame.error else "remote request" if frame.remote else signals_text(frame)
        print(
            f"({frame.t_us / 1e6:.6f}) {frame.channel} {frame.frame_id:03X} {frame.name} [{verdict.text}] {kind}",
            flush=str(log) == "-",  # live traffic appears at once
        )
