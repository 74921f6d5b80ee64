"""Computes load and worst-case response times of the bus: ``python -m comanip_dev.bus.report [FILE]``
(``make bus-report``).

Prints the worst case of each frame for 4, 6, 7 and 8 joints on CAN FD and classic CAN, and marks frames that miss their
deadline. Also writes the results to FILE (JSON). Exit status: 0, even if frames are late; 2 usage error.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from comanip.bus.frame_length import BitRates
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from comanip_dev.bus.response_time import analyse, load
from comanip_dev.bus.traffic import (
    ASSUMPTIONS,
    NS_PER_MS,
    Frame,
    classic_boot_frames,
    classic_frames,
    fd_boot_frames,
    fd_frames,
    streams,
)

JOINTS = (4, 6, 7, 8)
TABLE_COLUMNS = 120


@dataclass(frozen=True)
class Profile:
    name: str
    rates: BitRates
    frames: Callable[[int], list[Frame]]
    boot_frames: Callable[[], list[Frame]]


PROFILES = (
    Profile("CAN FD 1/5 Mbit/s", BitRates(1_000_000, 5_000_000), fd_frames, fd_boot_frames),
    Profile("CAN FD 1/8 Mbit/s", BitRates(1_000_000, 8_000_000), fd_frames, fd_boot_frames),
    Profile("classic 1 Mbit/s", BitRates(1_000_000), classic_frames, classic_boot_frames),
)


@dataclass(frozen=True)
class Row:
    """The worst case of a frame. queued_ms: time from the queueing of the frame to its end. response_ms: time from its
    event to its end. For cyclic frames of the firmware and of the drives, the event is the tick. For frames that are
    sent on events, response_ms equals queued_ms. None: unbounded, because the bus is overloaded. deadline_ms: for
    cyclic frames the period."""

    name: str
    id: int
    bytes: int
    period_ms: int
    deadline_ms: int
    cyclic: bool
    longest_us: float
    queued_ms: float | None
    response_ms: float | None
    late: bool


@dataclass(frozen=True)
class Result:
    """The results for one profile and number of joints. Loads assume the longest frames. late_at_boot: names of frames
    that are late while the boot frames are sent."""

    profile: str
    joints: int
    load_percent: float
    load_cyclic_percent: float
    rows: tuple[Row, ...]
    late: tuple[str, ...]
    late_at_boot: tuple[str, ...]


def rows(frames: Sequence[Frame], rates: BitRates) -> list[Row]:
    """Returns the rows, sorted by id."""
    all_streams = streams(frames, rates)
    found = analyse(all_streams, rates.nominal_ns)
    result = []
    for frame, stream in sorted(zip(frames, all_streams, strict=True), key=lambda pair: pair[0].identifier):
        queued_ns, event_ns = found[frame.name].queued_ns, found[frame.name].event_ns
        response_ns = event_ns if frame.is_cyclic else queued_ns
        result.append(
            Row(
                frame.name,
                frame.identifier,
                frame.length,
                frame.period_ms,
                frame.deadline_ms,
                frame.is_cyclic,
                stream.longest_ns / 1000,
                None if queued_ns is None else queued_ns / NS_PER_MS,
                None if response_ns is None else response_ns / NS_PER_MS,
                response_ns is None or response_ns > frame.deadline_ms * NS_PER_MS,
            )
        )
    return result


def result(profile: Profile, joints: int) -> Result:
    frames = profile.frames(joints)
    running = rows(frames, profile.rates)
    booting = rows([*frames, *profile.boot_frames()], profile.rates)
    return Result(
        profile.name,
        joints,
        100 * load(streams(frames, profile.rates)),
        100 * load(streams([frame for frame in frames if frame.is_cyclic], profile.rates)),
        tuple(running),
        tuple(row.name for row in running if row.late),
        tuple(row.name for row in booting if row.late),
    )


# ---- output


def names(late: Sequence[str]) -> str:
    """Returns the names as text, in which JointState4, JointState5, JointState6 is shortened to JointState4..6."""
    families: dict[str, list[str]] = {}
    for name in late:
        families.setdefault(name.rstrip("0123456789"), []).append(name)
    texts = [group[0] + (f"..{group[-1][len(stem) :]}" if len(group) > 1 else "") for stem, group in families.items()]
    return ", ".join(texts) or "-"


def overview(results: Sequence[Result]) -> Table:
    table = Table(title="Bus load, and frames that are late in the worst case", title_justify="left")
    for header in ("profile", "joints", "load, all", "cyclic", "last joint state", "too late", "too late at boot"):
        table.add_column(header, justify="right" if header in ("joints", "load, all", "cyclic") else "left")
    for item in results:
        last = next(row for row in item.rows if row.name.endswith(f"JointState{item.joints - 1}"))
        table.add_row(
            item.profile,
            str(item.joints),
            f"{item.load_percent:.1f} %",
            f"{item.load_cyclic_percent:.1f} %",
            f"{time_text(last)} of {last.period_ms} ms",
            f"[red]{names(item.late)}[/]" if item.late else "-",
            names(item.late_at_boot),
        )
    return table


def time_text(row: Row | None) -> str:
    """Formats a response time, in red and with an exclamation mark if the frame is late."""
    if row is None:
        return ""
    text = "no bound" if row.response_ms is None else f"{row.response_ms:.3f}"
    return f"[red]{text} ![/]" if row.late else text


def details(results: Sequence[Result]) -> Table:
    """Returns the table of one profile, with a row per frame and a column per number of joints."""
    table = Table(title=f"{results[0].profile}: worst-case response in ms", title_justify="left")
    columns = ("id", "frame", "bytes", "us at most", "period ms", *(f"{item.joints} joints" for item in results))
    for header in columns:
        table.add_column(header, justify="left" if header in ("id", "frame") else "right")
    for row in max(results, key=lambda item: item.joints).rows:
        found = [next((own for own in item.rows if own.name == row.name), None) for item in results]
        period = f"{row.period_ms}" if row.cyclic else "event"
        table.add_row(
            f"{row.id:03X}", escape(row.name), str(row.bytes), f"{row.longest_us:.1f}", period, *map(time_text, found)
        )
    return table


def show(results: Sequence[Result], console: Console) -> None:
    console.print(overview(results))
    for profile in dict.fromkeys(item.profile for item in results):
        console.print()
        console.print(details([item for item in results if item.profile == profile]))
    console.print("\nFrame durations are the longest over all payloads, with stuff bits. Response time: from the tick")
    console.print("or the queueing to the end of the frame; ! marks frames that end after their deadline. Assumptions:")
    for line in ASSUMPTIONS:
        console.print(f"- {line}", highlight=False)


def write_json(results: Sequence[Result], path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    unfinished = path.with_name(path.name + ".part")
    content = {"assumptions": ASSUMPTIONS, "results": [asdict(item) for item in results]}
    unfinished.write_text(json.dumps(content, indent=1) + "\n")
    unfinished.replace(path)


def main(argv: Sequence[str]) -> int:
    if len(argv) > 1 or any(argument.startswith("-") for argument in argv):
        print("usage: python -m comanip_dev.bus.report [FILE]", file=sys.stderr)
        return 2
    results = [result(profile, joints) for profile in PROFILES for joints in JOINTS]
    if argv:
        try:
            write_json(results, Path(argv[0]))
        except OSError as error:
            print(f"bus_report: {argv[0]}: cannot be written: {error.strerror}", file=sys.stderr)
            return 2
    console = Console()
    show(results, console if console.is_terminal else Console(width=TABLE_COLUMNS))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
