"""Acts as the operator on the bus: sends commands and parameter requests, and waits for the answers.

A request that is not answered is sent again, with a new counter and the same sequence number. If the firmware refuses a
request, a RefusedError that names the result is raised.
"""

from __future__ import annotations

import random
import struct
import time
from collections.abc import Iterator
from dataclasses import dataclass

from comanip.bus.frame import Frame, database, decode
from comanip.bus.live import LiveBus
from comanip.errors import ToolError

ATTEMPTS = 5
ANSWER_S = 0.1  # the firmware answers within two ticks: 2 ms on CAN FD, 8 ms on classic CAN
SAVE_S = 2.0  # the firmware answers only after the record is stored, possibly on a slow card
ACCEPTED = "accepted"
UNSTABLE = "parameters_unstable"


class RefusedError(ToolError):
    """The firmware refused a request. result: the firmware's result, which names the reason. involved: names and values
    of the parameters that the firmware reports after the refusal."""

    def __init__(self, request: str, result: str, involved: dict[str, float] | None = None):
        self.result, self.involved = result, involved or {}
        named = ", ".join(f"{name} = {value:g}" for name, value in self.involved.items())
        super().__init__(
            f"{request}: refused: {result}{_WHY.get(result, '').format(named=named or 'the firmware named none')}"
        )


_WHY = {
    "wrong_mode": " (`start` requires mode ready, `latch` and `clutch` a running cooperation, `acknowledge` a stopped "
    "one; parameters require the arm at rest)",
    "tracker_stale": " (the arm holds because poses of the hand no longer arrive)",
    "fault_present": " (the cause of the fault is still present: `comanip monitor` shows it)",
    "not_at_rest": " (the arm moves, or moved less than 50 ms ago: repeat the command once it stands still)",
    "joint_out_of_range": " (move the arm by hand until all joints are within their ranges)",
    "not_acknowledged": " (a fault is latched, and `comanip monitor` shows its reason: once its cause is gone, "
    "`comanip task acknowledge` clears it)",
    "out_of_range": " (docs/bus.md and `comanip param list` show the ranges)",
    UNSTABLE: " (with these values together the arm cannot come to rest: {named}; choose values nearer to the defaults "
    "that `comanip param list` shows)",
    "not_supported": " (this firmware has no parameter store: on Linux, run it with --parameters FILE)",
    "store_failed": " (the firmware could not write its store; the parameters saved before are unchanged. Its console "
    "shows the reason)",
}


def choices(message: str, signal: str) -> list[str]:
    """Returns the names of an enumerated signal's values, sorted by value."""
    table = database().get_message_by_name(message).get_signal_by_name(signal).choices
    return [str(table[number]) for number in sorted(table)]


def parameter_names() -> list[str]:
    return choices("ParameterValue", "parameter")


def as_float32(value: float) -> float:
    """Returns the value rounded to float32, as on the bus. Raises ToolError if it exceeds the range of float32."""
    try:
        return struct.unpack("<f", struct.pack("<f", value))[0]
    except OverflowError:
        raise ToolError(f"{value:g}: expected a number that fits into float32") from None


@dataclass(frozen=True)
class ParameterAnswer:
    value: float  # the value that the firmware uses
    result: str


class OperatorClient:
    def __init__(self, bus: LiveBus, attempts: int = ATTEMPTS, answer_s: float = ANSWER_S):
        self._bus, self._attempts, self._answer_s = bus, attempts, answer_s
        self._sequence = random.randrange(1, 256)

    # ---- requests

    def command(self, name: str, task: str = "pour") -> None:
        """Sends a command. task: used by `select` only. Raises RefusedError if the firmware refuses the command, and
        ToolError if it does not answer."""
        answer = self._request("OperatorCommand", {"command": name, "task": task}, "CommandAck", {"command": name})
        if answer["result"] != ACCEPTED:
            raise self._refused(f"{name} {task}" if name == "select" else name, str(answer["result"]))

    def read(self, parameter: str) -> float:
        answer = self._access("read", parameter, 0.0)
        if answer.result != ACCEPTED:
            raise RefusedError(f"{parameter}", answer.result)
        return answer.value

    def write(self, parameter: str, value: float) -> None:
        """Writes the value and checks it by reading it back."""
        requested = as_float32(value)
        answer = self._access("write", parameter, requested)
        if answer.result != ACCEPTED:
            raise RefusedError(f"{parameter} = {value:g} (present value: {answer.value:g})", answer.result)
        found = self.read(parameter)
        if found != requested:
            raise ToolError(f"{parameter}: accepted as {requested:g}, but reads back as {found:g}")

    def save(self) -> None:
        """Saves all parameters for the next boot. On return they are in non-volatile memory."""
        answer = self._access("save", parameter_names()[0], 0.0, max(SAVE_S, self._answer_s))
        if answer.result != ACCEPTED:
            raise self._refused("save", answer.result)

    # ---- one request and its answer

    def _refused(self, request: str, result: str) -> RefusedError:
        """Returns the error for a refusal. If the reason is UNSTABLE, waits for the parameters involved, which the
        firmware reports one per tick, and includes them in the error."""
        involved = {}
        while result == UNSTABLE and (found := self._next_unstable()):
            involved[str(found["parameter"])] = found["value"]
        return RefusedError(request, result, involved)

    def _next_unstable(self) -> dict | None:
        for frame in self._received(self._answer_s):
            found = decode(frame) if frame.name == "ParameterValue" else None
            if found and found["sequence"] == self._sequence and str(found["result"]) == UNSTABLE:
                return found
        return None

    def _access(self, operation: str, parameter: str, value: float, answer_s: float | None = None) -> ParameterAnswer:
        signals = {"operation": operation, "parameter": parameter, "value": value}
        answer = self._request("ParameterAccess", signals, "ParameterValue", {"parameter": parameter}, answer_s)
        return ParameterAnswer(answer["value"], str(answer["result"]))

    def _request(self, request: str, signals: dict, answer: str, expected: dict, answer_s: float | None = None) -> dict:
        answer_s = self._answer_s if answer_s is None else answer_s
        self._sequence = self._sequence % 255 + 1  # 0 marks the values that the firmware sends at boot
        expected = expected | {"sequence": self._sequence}
        for _ in range(self._attempts):
            self._bus.send(request, signals | {"sequence": self._sequence})
            for frame in self._received(answer_s):
                found = decode(frame) if frame.name == answer else None
                if found and all(found[name] == value for name, value in expected.items()):
                    return found
        raise ToolError(
            f"{request}: no {answer} in {self._attempts} attempts of {1000 * answer_s:g} ms: "
            "does the firmware run on this bus?"
        )

    def _received(self, duration_s: float) -> Iterator[Frame]:
        """Yields the frames received within the duration. A busy bus may deliver frames faster than this process reads
        them. Frames that are still waiting after the duration are therefore yielded as well, for at most the same
        duration again."""
        deadline_s = time.monotonic() + duration_s
        while True:
            frame = self._bus.receive_until(deadline_s)
            if frame is not None:
                yield frame
            late_s = time.monotonic() - deadline_s
            if late_s >= duration_s or (late_s >= 0 and frame is None):
                return
