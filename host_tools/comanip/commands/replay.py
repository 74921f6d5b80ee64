"""``comanip replay``: replays a log and compares what the firmware sends with what was recorded."""

from __future__ import annotations

import bisect
import time
from typing import Annotated

import typer
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from comanip.bus import logs
from comanip.bus.frame import Frame, decode, signals_text
from comanip.commands.options import LogPath, console, examples
from comanip.errors import ToolError
from comanip.replay import Difference, Replay

STATUS_DIFFERENT = 1
PACE_STEP_S = 0.02
HELP = examples(
    "comanip replay out/pour/bus.log            at full speed",
    "comanip replay out/pour/bus.log --pace     at the recorded speed, printing each change of mode",
    "comanip replay recorded.blf",
)


def _run_paced(replaying: Replay) -> None:
    """Replays at the recorded speed, using the timestamps in the log, and prints each change of mode."""
    frames = replaying.frames
    times_us = [frame.t_us for frame in frames]
    begin_s, mode, index, more = time.monotonic(), None, 0, True
    while more and index < len(frames):
        elapsed_us = round(1e6 * (time.monotonic() - begin_s))
        end = bisect.bisect_right(times_us, times_us[0] + elapsed_us)
        more = replaying.run_to(end)
        for frame in frames[index:end]:
            mode = _print_mode_change(frame, mode, times_us[0])
        index = end
        time.sleep(PACE_STEP_S)


def _print_mode_change(frame: Frame, previous: tuple | None, begin_us: int) -> tuple | None:
    """Prints the mode and the reason if this frame changes them. Returns (mode, reason) after this frame."""
    if frame.name != "FirmwareStatus" or (status := decode(frame)) is None:
        return previous
    mode = (str(status["mode"]), str(status["reason"]))
    if mode != previous:
        console().print(f"{(frame.t_us - begin_us) / 1e6:9.3f} s  {mode[0]} ({mode[1]})")
    return mode


def _run_fast(replaying: Replay) -> None:
    columns = (TextColumn("replay"), BarColumn(), TextColumn("{task.percentage:3.0f} %"), TimeElapsedColumn())
    with Progress(*columns, console=console(), transient=True) as progress:
        task = progress.add_task("", total=len(replaying.frames))
        for done in replaying.run():
            progress.update(task, completed=done)


def _print_difference(difference: Difference, begin_us: int) -> None:
    out = console()
    frame = difference.recorded
    out.print(
        f"[red]different[/red] at {frame.t_us / 1e6:.6f} s ({(frame.t_us - begin_us) / 1e6:.6f} s into the log), "
        f"frame {difference.place + 1}, id 0x{frame.frame_id:03X} {frame.name}: {difference.what}",
        soft_wrap=True,
    )
    out.print(f"  recorded {frame.data.hex().upper()}", soft_wrap=True)
    out.print(f"           {signals_text(frame)}", soft_wrap=True, markup=False)
    sent = difference.sent
    if sent is None:
        return
    out.print(f"  replayed {sent.data.hex().upper()}", soft_wrap=True)
    out.print(f"           {signals_text(sent)}", soft_wrap=True, markup=False)
    recorded, replayed = decode(frame) or {}, decode(sent) or {}
    if recorded.keys() == replayed.keys():
        for name in recorded:
            if recorded[name] != replayed[name]:
                out.print(f"  {name}: recorded {recorded[name]}, replayed {replayed[name]}", soft_wrap=True)


def replay(
    log: LogPath,
    pace: Annotated[
        bool, typer.Option("--pace", help="Replay at the recorded speed instead of as fast as possible.")
    ] = False,
) -> None:
    """Replay a log with the C core, and compare the frames that the core sends with the recorded ones, byte for byte.

    Exit status: 0 equal, 1 different (the first difference is shown), 2 the log cannot be replayed.
    """
    frames = list(logs.read(log))
    try:
        replaying = Replay(frames)
    except ToolError as error:
        raise ToolError(f"{log}: {error}") from error
    began_s = time.monotonic()
    (_run_paced if pace else _run_fast)(replaying)
    report = replaying.report()
    took_s = time.monotonic() - began_s
    if report.other_build is not None:
        console().print(
            f"{log}: recorded by another build, {report.other_build:016x}; not compared: {', '.join(report.left_out)}",
            soft_wrap=True,
        )
    elif report.left_out:
        console().print(
            f"{log}: not compared, because the log does not determine it: {', '.join(report.left_out)}", soft_wrap=True
        )
    boots = f", {report.boots} boots" if report.boots > 1 else ""
    if report.difference is not None:
        _print_difference(report.difference, frames[0].t_us)
    verdict = "[red]DIFFERENT[/red]" if report.difference else "[green]EQUAL[/green]"
    console().print(
        f"{log}: {verdict}: {report.ticks} ticks{boots}, {report.fed} received and {report.compared} sent frames "
        f"replayed; {took_s:.1f} s",
        soft_wrap=True,
    )
    if report.difference is not None:
        raise typer.Exit(STATUS_DIFFERENT)
