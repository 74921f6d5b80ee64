"""Options that several commands have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from comanip.bus.transport import Profile

Interface = Annotated[
    str,
    typer.Option(
        "--interface", "-i", envvar="COMANIP_INTERFACE", help="python-can's name: socketcan, socketcand, pcan, ..."
    ),
]
Channel = Annotated[
    str, typer.Option("--channel", "-c", envvar="COMANIP_CHANNEL", help="which bus of the interface: vcan0, can0, ...")
]
Host = Annotated[str, typer.Option(help="of socketcand")]
Port = Annotated[int, typer.Option(min=1, max=65535, help="of socketcand")]
BusProfile = Annotated[
    Profile | None,
    typer.Option(
        "--profile",
        envvar="COMANIP_PROFILE",
        help="Of the bus; else as its frames tell, fd if there are none.",
        show_default=False,
    ),
]
INTERFACE, CHANNEL, HOST, PORT = "socketcan", "vcan0", "127.0.0.1", 29536

LogPath = Annotated[
    Path, typer.Argument(help="of candump -L or python-can: .log, .asc, .blf, .trc", show_default=False)
]


def examples(*lines: str) -> str:
    """The end of a command's help."""
    return "[bold]Examples[/bold]\n\n" + "\n\n".join(f"  {line}" for line in lines)


def console() -> Console:
    """For what people read."""
    return Console(highlight=False)
