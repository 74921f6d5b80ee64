"""``comanip param``: lists, reads, writes and saves the firmware's parameters over the bus."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.table import Table

from comanip.bus.live import BusAddress, open_bus
from comanip.bus.operator_client import OperatorClient, parameter_names
from comanip.commands.options import console, examples, takes_bus
from comanip.errors import ToolError
from comanip.parameters import all_parameters

HELP = examples(
    "comanip param list",
    "comanip param get motion_scale",
    "comanip param set motion_scale 0.5",
    "comanip param save",
)
Name = Annotated[str, typer.Argument(help="A name from `comanip param list`.", show_default=False)]

LIST_COLUMNS = 200

app = typer.Typer(no_args_is_help=True, help="List, read, write and save parameters.", epilog=HELP)


def _require_name(name: str) -> None:
    if name not in parameter_names():
        raise ToolError(f"parameter '{name}': no such parameter, expected one of {', '.join(parameter_names())}")


@app.command("list", epilog=examples("comanip param list -i socketcand"))
@takes_bus
def list_(
    address: BusAddress,
) -> None:
    """Show the present value of each parameter, with its unit, range, default and meaning."""
    table = Table(box=None, pad_edge=False)
    for column in ("parameter", "value", "from", "to", "default", "unit", "meaning"):
        table.add_column(column, no_wrap=True)
    with open_bus(address) as bus:
        client = OperatorClient(bus)
        for name, parameter in all_parameters().items():
            bounds = (f"{bound:.7g}" for bound in (parameter.minimum, parameter.maximum, parameter.default))
            table.add_row(name, f"{client.read(name):.7g}", *bounds, parameter.unit, parameter.meaning)
    out = console()
    out.width = max(out.width, LIST_COLUMNS)  # one line per row, for scripts
    out.print(table)


@app.command(epilog=examples("comanip param get stale_periods"))
@takes_bus
def get(
    name: Name,
    address: BusAddress,
) -> None:
    """Read one parameter."""
    _require_name(name)
    with open_bus(address) as bus:
        console().print(f"{OperatorClient(bus).read(name):.7g}")


@app.command(
    "set",
    epilog=examples("comanip param set speed_fraction 0.3", "comanip param set tracker_rotation_x_rad -- -1.5708"),
)
@takes_bus
def set_(
    name: Name,
    value: Annotated[float, typer.Argument(help="In SI units; write -- before a negative value.", show_default=False)],
    address: BusAddress,
) -> None:
    """Write one parameter and read it back. The arm must be at rest. The value is lost at the next boot unless
    saved."""
    _require_name(name)
    with open_bus(address) as bus:
        OperatorClient(bus).write(name, value)
    console().print(f"{name} = {value:.7g}: accepted, reads back the same")


@app.command(epilog=examples("comanip param save"))
@takes_bus
def save(
    address: BusAddress,
) -> None:
    """Save all parameters in the firmware's store for the next boot. The arm must be at rest.

    The firmware answers not_supported if it has no store. On Linux the store is the file of its option --parameters.
    """
    with open_bus(address) as bus:
        OperatorClient(bus).save()
    console().print("saved: the firmware will load the present values at its next boot")
