"""``comanip convert``: writes a log in another format."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, BinaryIO

import typer

from comanip.bus import logs, mcap_log, pcap
from comanip.bus.frame import Frame
from comanip.commands.options import LogPath, console, examples
from comanip.errors import ToolError

HELP = examples(
    "comanip convert out/pour/bus.log pour.pcap        for Wireshark",
    "comanip convert out/pour/bus.log pour.mcap        for Foxglove, with decoded signals",
    "comanip convert recorded.blf recorded.log         as candump -L writes it",
)


def write_candump(file: BinaryIO, frames: Iterable[Frame]) -> int:
    count = 0
    for frame in frames:
        file.write(logs.candump_line(frame).encode("ascii") + b"\n")
        count += 1
    return count


WRITERS = {".log": write_candump, ".pcap": pcap.write, ".mcap": mcap_log.write}


def convert(
    log: LogPath,
    output: Annotated[
        Path,
        typer.Argument(help="The suffix determines the format: .log (candump -L), .pcap, .mcap", show_default=False),
    ],
) -> None:
    """Write a log in candump's format, as pcap (LINKTYPE 227) or as MCAP with decoded signals."""
    writer = WRITERS.get(output.suffix.lower())
    if writer is None:
        raise ToolError(
            f"{output}: unknown format '{output.suffix}', expected a name that ends in one of {', '.join(WRITERS)}"
        )
    if output.exists() and log.exists() and output.samefile(log):
        raise ToolError(f"{output}: is the log itself, expected another file")
    unfinished = output.with_name(output.name + ".partial")
    try:
        with open(unfinished, "wb") as file:
            count = writer(file, logs.read(log))
        unfinished.replace(output)
    except OSError as error:
        raise ToolError(f"{output}: cannot be written: {error.strerror or error}") from error
    finally:
        unfinished.unlink(missing_ok=True)
    console().print(f"{output}: {count} frames", soft_wrap=True)
