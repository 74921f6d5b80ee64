"""Options shared by several commands."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from comanip.bus.transport import Profile

Interface = Annotated[
    str,
    typer.Option(
        "--interface",
        "-i",
        envvar="COMANIP_INTERFACE",
        help="Interface as python-can names it: socketcan, socketcand, pcan, ...",
    ),
]
Channel = Annotated[
    str, typer.Option("--channel", "-c", envvar="COMANIP_CHANNEL", help="Bus of the interface: vcan0, can0, ...")
]
Host = Annotated[str, typer.Option(help="Host of socketcand.")]
Port = Annotated[int, typer.Option(min=1, max=65535, help="Port of socketcand.")]
BusProfile = Annotated[
    Profile | None,
    typer.Option(
        "--profile",
        envvar="COMANIP_PROFILE",
        help="CAN FD or classic CAN. By default detected from the traffic; fd if there is none.",
        show_default=False,
    ),
]
INTERFACE, CHANNEL, HOST, PORT = "socketcan", "vcan0", "127.0.0.1", 29536

LogPath = Annotated[
    Path, typer.Argument(help="A log of candump -L or python-can: .log, .asc, .blf, .trc", show_default=False)
]


def examples(*lines: str) -> str:
    """Formats the examples at the end of a command's help."""
    return "[bold]Examples[/bold]\n\n" + "\n\n".join(f"  {line}" for line in lines)


def console() -> Console:
    """Returns a console for human-readable output."""
    return Console(highlight=False)
