"""Assembles the commands of ``comanip``."""

from __future__ import annotations

import typer

from comanip.commands import calibrate, convert, decode, doctor, monitor, param, replay, sim, task, tracker

app = typer.Typer(
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    help="Lets a person and a robot arm work together over a CAN bus: simulate, monitor, record, replay, operate.",
    epilog="Each command has examples: comanip COMMAND --help. Shell completion: comanip --install-completion",
)
app.command(epilog=sim.HELP, context_settings={"allow_extra_args": True, "ignore_unknown_options": True})(sim.sim)
for module, command in (
    (replay, replay.replay),
    (monitor, monitor.monitor),
    (decode, decode.decode),
    (convert, convert.convert),
    (tracker, tracker.tracker),
    (calibrate, calibrate.calibrate),
    (doctor, doctor.doctor),
):
    app.command(epilog=module.HELP)(command)
app.add_typer(task.app, name="task")
app.add_typer(param.app, name="param")
