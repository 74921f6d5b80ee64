"""``comanip tracker``: publishes the poses of a person's hand, read from lines of text."""

from __future__ import annotations

import queue
import sys
import threading
import time
from collections.abc import Iterator
from typing import Annotated

import typer

from comanip.bus.live import BusAddress, open_bus
from comanip.commands.options import examples, takes_bus
from comanip.errors import ToolError
from comanip.tracker.pose_lines import ORDERS, Pose, parse
from comanip.tracker.publisher import TrackerPublisher, status_period_s

HELP = examples(
    "my_tracker | comanip tracker --stdin",
    "comanip tracker --stdin --pace < hand.csv          a recording, at its recorded pace",
    "ros2_poses_as_json | comanip tracker --stdin --quaternion xyzw -i socketcand",
)
QUEUE_LINES = 1000


def _lines(queue_: queue.Queue) -> None:
    for line in sys.stdin:
        queue_.put(line)
    queue_.put(None)


def _read(lines: queue.Queue, order: str, status_s: float, on_bad) -> Iterator[Pose | None]:
    """Yields each pose, and None whenever a TrackerStatus is due. Calls on_bad for each malformed line. Stops at the
    end of the input."""
    number = 0
    due_s = time.monotonic()
    while True:
        try:
            line = lines.get(timeout=max(0.0, due_s - time.monotonic()))
        except queue.Empty:
            due_s = time.monotonic() + status_s
            yield None
            continue
        if line is None:
            return
        number += 1
        try:
            pose = parse(line, order)
        except ValueError as error:
            on_bad(number, str(error))
            continue
        if pose is not None:
            yield pose
        if time.monotonic() >= due_s:
            due_s = time.monotonic() + status_s
            yield None


class _Pace:
    """Waits until a pose is due according to its timestamp."""

    def __init__(self):
        self._offset_s: float | None = None

    def wait(self, pose: Pose) -> None:
        if pose.t_s is None:
            raise ToolError("--pace: a line has no timestamp, expected one at the start of each line")
        if self._offset_s is None:
            self._offset_s = time.monotonic() - pose.t_s
        time.sleep(max(0.0, self._offset_s + pose.t_s - time.monotonic()))


@takes_bus
def tracker(
    stdin: Annotated[bool, typer.Option("--stdin", help="Read poses from standard input, one per line.")] = False,
    quaternion: Annotated[
        str, typer.Option(help="Order of the quaternion's components in the lines: wxyz or xyzw.")
    ] = "wxyz",
    rate: Annotated[
        float | None,
        typer.Option(min=10, max=1000, help="Rate of the tracker in Hz. By default estimated from the timestamps."),
    ] = None,
    pace: Annotated[bool, typer.Option("--pace", help="Send each pose at its recorded time: for a recording.")] = False,
    *,
    address: BusAddress,
) -> None:
    """Publish poses as HandPose and TrackerStatus, with end-to-end protection.

    Lines are CSV or JSON, in metres, in the tracker's frame, with or without a leading timestamp in seconds:

    x,y,z,qw,qx,qy,qz   or 12 or 16 numbers of a matrix, row by row   or
    {"t": 0.1, "position": [x,y,z], "quaternion": [w,x,y,z]}   or {"matrix": [[...],[...],[...]]}.

    A malformed line is reported, counts as a lost sample and is sent as an invalid pose.
    Exit status: 0 all lines were valid, 1 some were malformed, 2 usage error.
    """
    if not stdin:
        raise ToolError("tracker: no source of poses, expected --stdin")
    if quaternion not in ORDERS:
        raise ToolError(f"--quaternion '{quaternion}': expected one of {', '.join(ORDERS)}")
    with open_bus(address) as bus:
        publisher = TrackerPublisher(bus, rate)
        bad = 0

        def on_bad(number: int, what: str) -> None:
            nonlocal bad
            bad += 1
            print(f"comanip: line {number}: {what}", file=sys.stderr)
            publisher.lose()

        lines: queue.Queue = queue.Queue(QUEUE_LINES)
        threading.Thread(target=_lines, args=(lines,), daemon=True).start()
        pacing = _Pace()
        try:
            for pose in _read(lines, quaternion, status_period_s(bus), on_bad):
                if pose is None:
                    publisher.publish_status()
                    continue
                if pace:
                    pacing.wait(pose)
                publisher.publish(pose)
        except KeyboardInterrupt:
            pass
        publisher.publish_status()  # with the final counts
    print(
        f"{publisher.sent} poses sent, {publisher.lost} lost, "
        f"{publisher.range_errors} of them out of the signals' range",
        file=sys.stderr,
    )
    if bad:
        raise typer.Exit(1)
