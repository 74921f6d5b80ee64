"""``comanip monitor``: shows the traffic and the firmware's state as a live table."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from comanip.bus import logs
from comanip.bus.frame import Frame, signals_text
from comanip.bus.live import BusAddress, open_bus
from comanip.bus.state import BusState
from comanip.commands.options import console, examples, takes_bus
from comanip.errors import ToolError

HELP = examples(
    "comanip monitor                                   vcan0 through SocketCAN",
    "comanip monitor -i socketcand -c vcan0            through a hub, without CAN in the kernel",
    "comanip monitor --log out/pour/bus.log            a log, at its recorded pace",
    "comanip monitor --once --duration 2               one table after two seconds, for scripts",
)
REFRESH_S = 0.2
MODE_STYLE = {"cooperating": "green", "ready": "cyan", "hold": "yellow", "fault": "bold red"}
NO_POSE_US = 2**24 - 1
CAN_FAULTS = {"error_passive": "error-passive", "bus_off": "bus-off"}
PORT_COUNTS = {  # texts for the counts in PortStatus: (singular, plural)
    "refused_frames": ("frame not sent", "frames not sent"),
    "lost_frames": ("received frame lost", "received frames lost"),
    "error_passive": ("time error-passive", "times error-passive"),
    "bus_off": ("time bus-off", "times bus-off"),
    "missed_ticks": ("tick missed", "ticks missed"),
}


def render(state: BusState, now_us: int, source: str) -> Group:
    """Returns the whole display. now_us: current time on the frames' clock."""
    return Group(_head(state, now_us, source), _table(state, now_us))


def _head(state: BusState, now_us: int, source: str) -> Text:
    status, trace = state.signals("FirmwareStatus"), state.signals("TickTrace")
    text = Text()
    if status:
        mode = str(status["mode"])
        text.append(f"{mode} ", MODE_STYLE.get(mode, ""))
        text.append(f"({status['reason']}), task {status['task']}{', latched' if status['latched'] else ''}, ")
        text.append(f"speed limit {status['speed_limit_percent']:g} %, refused frames {status['rejected_frames']}\n")
        if status["rest_not_assured"]:
            text.append("with these parameters the arm may keep moving while the hand rests\n", "yellow")
        if status["changes_posture"]:
            text.append("the arm is changing its posture to reach the target\n", "yellow")
    else:
        text.append("no FirmwareStatus received: probably the firmware does not run on this bus\n", "yellow")
    if line := port_faults(state.signals("PortStatus")):
        text.append(f"{line}\n", "bold red" if "bus-off now" in line else "yellow")
    if trace:
        age_us = int(trace["hand_age_us"])
        hand = "no hand yet" if age_us >= NO_POSE_US else f"hand {age_us / 1000:.1f} ms old"
        text.append(f"{hand}, drives {'answer' if trace['drives_fresh'] else 'silent'}, ")
    refused = sum(row.refused for row in state.ids.values())
    text.append(
        f"bus load at most {state.load_percent(now_us):.1f} %, {state.rate_hz(now_us):.0f} frames/s, "
        f"{state.frames} frames, {state.error_frames} error frames, {refused} E2E errors\n{source}\n"
    )
    return text


def port_faults(signals: dict) -> str:
    """Returns the faults in a PortStatus as one line, or "" if there are none. Leaves out values that the port does not
    know."""
    known = {name: value for name, value in signals.items() if isinstance(value, int)}
    parts = [
        f"{known[name]} {one if known[name] == 1 else many}"
        for name, (one, many) in PORT_COUNTS.items()
        if known.get(name)
    ]
    if (state := str(signals.get("can_state"))) in CAN_FAULTS:
        parts.insert(0, f"{CAN_FAULTS[state]} now")
    if parts and "longest_tick_us" in known:
        parts.append(f"longest tick {known['longest_tick_us'] / 1000:.1f} ms")
    return f"port, since boot: {', '.join(parts)}" if parts else ""


def _table(state: BusState, now_us: int) -> Table:
    table = Table(
        "id", "message", "from", "count", "Hz", "age ms", "E2E", "signals", box=None, pad_edge=False, expand=True
    )
    for column, (width, justify) in enumerate(
        ((5, "left"), (17, "left"), (9, "left"), (7, "right"), (6, "right"), (8, "right"))
    ):
        table.columns[column].min_width, table.columns[column].justify = width, justify
        table.columns[column].no_wrap = True
    table.columns[-1].no_wrap, table.columns[-1].overflow, table.columns[-1].ratio = True, "ellipsis", 1
    for (frame_id, extended), row in sorted(state.ids.items()):
        message = row.last.message
        verdict = f"{row.refused} wrong" if row.refused else "" if row.verdict.ok is None else "ok"
        table.add_row(
            f"{frame_id:08X}" if extended else f"{frame_id:03X}",
            message.name if message else "?", ", ".join(message.senders) if message else "", str(row.count),
            f"{row.rate_hz(now_us):.0f}", f"{(now_us - row.last.t_us) / 1000:.0f}",
            Text(verdict, "red" if row.refused else ""), Text(signals_text(row.last)),
        )  # fmt: skip
    return table


def _from_bus(bus) -> Iterator[Frame | None]:
    while True:
        yield bus.receive_frame(REFRESH_S / 4)


def _from_log(path: Path) -> Iterator[Frame | None]:
    """Yields the frames of a log at their recorded pace, and None while no frame is due."""
    begin_s = first_us = None
    for frame in logs.read(path):
        if first_us is None:
            begin_s, first_us = time.monotonic(), frame.t_us
        while (ahead_s := (frame.t_us - first_us) / 1e6 - (time.monotonic() - begin_s)) > 0:
            time.sleep(min(ahead_s, REFRESH_S / 4))
            yield None
        yield frame


class _Clock:
    """The frames' clock, extrapolated with this machine's clock so that ages keep growing while the bus is silent."""

    def __init__(self):
        self._newest_us, self._at_s = 0, time.monotonic()

    def feed(self, t_us: int) -> None:
        self._newest_us, self._at_s = t_us, time.monotonic()

    def now_us(self) -> int:
        return self._newest_us + round(1e6 * (time.monotonic() - self._at_s))


def _watch(frames: Iterator[Frame | None], state: BusState, clock: _Clock, duration_s: float | None, refresh) -> None:
    begin_s = shown_s = time.monotonic()
    for frame in frames:
        if frame is not None:
            state.feed(frame)
            clock.feed(frame.t_us)
        now_s = time.monotonic()
        if now_s - shown_s > REFRESH_S:
            refresh()
            shown_s = now_s
        if duration_s is not None and now_s - begin_s > duration_s:
            return


def _show(frames: Iterator[Frame | None], source: str, duration_s: float | None, once: bool) -> None:
    state, clock, out = BusState(), _Clock(), console()
    try:
        if once:
            _watch(frames, state, clock, duration_s, lambda: None)
            out.print(render(state, clock.now_us(), source))
            return
        with Live(console=out, auto_refresh=False, screen=out.is_terminal) as live:
            _watch(
                frames,
                state,
                clock,
                duration_s,
                lambda: live.update(render(state, clock.now_us(), source), refresh=True),
            )
        out.print(render(state, clock.now_us(), source))
    except KeyboardInterrupt:
        pass


@takes_bus
def monitor(
    address: BusAddress,
    log: Annotated[Path | None, typer.Option(help="A log instead of a bus, at its recorded pace.")] = None,
    duration: Annotated[
        float | None, typer.Option(min=0.0, help="Stop after this many seconds instead of at Ctrl-C or the log's end.")
    ] = None,
    once: Annotated[
        bool, typer.Option("--once", help="Print one table at the end; requires --duration or --log.")
    ] = False,
) -> None:
    """Show mode, reason, ages, rates, load, errors and decoded signals. Sends nothing."""
    if once and duration is None and log is None:
        raise ToolError("--once: expected --duration SECONDS or --log LOG, which determine when to print the table")
    if log is not None:
        _show(_from_log(log), f"{log}, at its recorded pace", duration, once)
        return
    with open_bus(address) as bus:
        _show(_from_bus(bus), str(address), duration, once)
