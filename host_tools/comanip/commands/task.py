"""``comanip task``: what the operator tells the firmware to do."""

from __future__ import annotations

from typing import Annotated

import typer

from comanip.bus.live import BusAddress, open_bus
from comanip.bus.operator_client import OperatorClient, choices
from comanip.bus.transport import Profile
from comanip.commands.options import (
    CHANNEL,
    HOST,
    INTERFACE,
    PORT,
    BusProfile,
    Channel,
    Host,
    Interface,
    Port,
    console,
    examples,
)
from comanip.errors import ToolError

HELP = examples(
    "comanip task select mirror",
    "comanip task start -i socketcand -c vcan0",
    "comanip task stop",
)
CUSTOM = "custom"  # is defined by a TaskDefine, not selected

app = typer.Typer(no_args_is_help=True, help="Select and start a task, latch, clutch, stop.", epilog=HELP)


def _tell(
    interface: str, channel: str, host: str, port: int, profile: Profile | None, command: str, task: str = "pour"
) -> None:
    with open_bus(BusAddress(interface, channel, host, port, profile)) as bus:
        OperatorClient(bus).command(command, task)
    console().print(f"{command}{' ' + task if command == 'select' else ''}: accepted")


@app.command(epilog=examples("comanip task select pour"))
def select(
    task: Annotated[str, typer.Argument(help="pour, teleop or mirror", show_default=False)],
    interface: Interface = INTERFACE, channel: Channel = CHANNEL, host: Host = HOST, port: Port = PORT, profile: BusProfile = None,
) -> None:  # fmt: skip
    """Select the task: which relative pose the two hands shall keep."""
    known = [name for name in choices("OperatorCommand", "task") if name != CUSTOM]
    if task not in known:
        raise ToolError(f"task '{task}': no such task, expected one of {', '.join(known)}")
    _tell(interface, channel, host, port, profile, "select", task)


def _add(command: str, text: str) -> None:
    def run(
        interface: Interface = INTERFACE,
        channel: Channel = CHANNEL,
        host: Host = HOST,
        port: Port = PORT,
        profile: BusProfile = None,
    ) -> None:
        _tell(interface, channel, host, port, profile, command)

    app.command(command, help=text, epilog=examples(f"comanip task {command}"))(run)


_add("start", "Begin to cooperate: the arm follows the hand from here on.")
_add("latch", "Keep the relative pose of this moment as the task.")
_add("clutch", "Let the hand move away without the arm: the relation is taken anew.")
_add("stop", "End the cooperation; also leaves a fault whose cause is gone.")
