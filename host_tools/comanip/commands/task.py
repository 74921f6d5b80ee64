"""``comanip task``: sends the operator's commands to the firmware."""

from __future__ import annotations

from typing import Annotated

import typer

from comanip.bus.live import BusAddress, open_bus
from comanip.bus.operator_client import OperatorClient, choices
from comanip.commands.options import console, examples, takes_bus
from comanip.errors import ToolError

HELP = examples(
    "comanip task select mirror",
    "comanip task start -i socketcand -c vcan0",
    "comanip task stop",
    "comanip task acknowledge",
)
CUSTOM = "custom"  # the task that TaskDefine defines and selects; `select` does not offer it

app = typer.Typer(
    no_args_is_help=True, help="Select and start a task, latch, clutch, stop, acknowledge a fault.", epilog=HELP
)


def _command(address: BusAddress, command: str, task: str = "pour") -> None:
    with open_bus(address) as bus:
        OperatorClient(bus).command(command, task)
    console().print(f"{command}{' ' + task if command == 'select' else ''}: accepted")


@app.command(epilog=examples("comanip task select pour"))
@takes_bus
def select(
    task: Annotated[str, typer.Argument(help="pour, teleop or mirror", show_default=False)],
    address: BusAddress,
) -> None:
    """Select the task, which is the relative pose that the two hands keep."""
    known = [name for name in choices("OperatorCommand", "task") if name != CUSTOM]
    if task not in known:
        raise ToolError(f"task '{task}': no such task, expected one of {', '.join(known)}")
    _command(address, "select", task)


def _add(command: str, text: str) -> None:
    @takes_bus
    def run(address: BusAddress) -> None:
        _command(address, command)

    app.command(command, help=text, epilog=examples(f"comanip task {command}"))(run)


_add("start", "Start the cooperation: from now on the arm follows the hand.")
_add("latch", "Latch the task: keep the relative pose of this moment.")
_add("clutch", "Take the present poses of both hands as the new reference. The task continues; the arm does not jump.")
_add("stop", "Stop the cooperation.")
_add(
    "acknowledge",
    "Acknowledge a fault, at standstill and once its cause is gone, so that the arm can be started again.",
)
