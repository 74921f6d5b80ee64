"""Options shared by several commands."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from comanip.bus.live import BusAddress
from comanip.bus.transport import Profile

# The command-line option for each field of BusAddress. The default values are those of BusAddress.
_BUS_OPTIONS = {
    "interface": Annotated[
        str,
        typer.Option(
            "--interface",
            "-i",
            envvar="COMANIP_INTERFACE",
            help="Interface as python-can names it: socketcan, socketcand, pcan, ...",
        ),
    ],
    "channel": Annotated[
        str, typer.Option("--channel", "-c", envvar="COMANIP_CHANNEL", help="Bus of the interface: vcan0, can0, ...")
    ],
    "host": Annotated[str, typer.Option(help="Host of socketcand.")],
    "port": Annotated[int, typer.Option(min=1, max=65535, help="Port of socketcand.")],
    "profile": Annotated[
        Profile | None,
        typer.Option(
            "--profile",
            envvar="COMANIP_PROFILE",
            help="CAN FD or classic CAN. By default detected from the traffic; fd if there is none.",
            show_default=False,
        ),
    ],
}

LogPath = Annotated[
    Path,
    typer.Argument(
        help="A log of candump -L or python-can: .log, .log.gz, .log.xz, .asc, .blf, .trc", show_default=False
    ),
]


def takes_bus(command: Callable[..., None]) -> Callable[..., None]:
    """Replaces a command's parameter `address`, a BusAddress, by the options that select a bus."""
    signature, default = inspect.signature(command, eval_str=True), BusAddress()
    kind = inspect.Parameter.KEYWORD_ONLY
    options = [
        inspect.Parameter(name, kind, annotation=annotation, default=getattr(default, name))
        for name, annotation in _BUS_OPTIONS.items()
    ]
    parameters = []
    for parameter in signature.parameters.values():
        parameters += options if parameter.name == "address" else [parameter.replace(kind=kind)]

    def with_options(**values: object) -> None:
        address = BusAddress(**{name: values.pop(name) for name in _BUS_OPTIONS})
        command(address=address, **values)

    with_options.__name__, with_options.__doc__ = command.__name__, command.__doc__
    with_options.__signature__ = signature.replace(parameters=parameters)
    with_options.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return with_options


def examples(*lines: str) -> str:
    """Formats the examples at the end of a command's help."""
    return "[bold]Examples[/bold]\n\n" + "\n\n".join(f"  {line}" for line in lines)


def console() -> Console:
    """Returns a console for human-readable output."""
    return Console(highlight=False)
