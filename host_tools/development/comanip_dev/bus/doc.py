"""docs/bus.md, written from comanip.dbc: ``python -m comanip_dev.bus.doc [FILE]`` writes the file, or prints it.

The DBC is the one place where frames are described (ids, layouts, scales, periods, Data IDs); this only makes it
readable. Frames that share a layout (JointState0..7) and signals that repeat per joint are told once.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import cantools
from cantools.database.can import Message, Signal
from comanip.bus.frame import DBC_PATH, is_classic

from comanip_dev import REPOSITORY

HEAD = """# The bus

Written by `make schema` from `firmware/schema/comanip.dbc`, the one place where frames are described: do not edit.

Two profiles, of which a bus has one: [CAN FD](#can-fd), with control at 1 kHz, and [classic CAN](#classic-can), with control at
250 Hz. Identifiers have 11 bits, signals are little-endian. Physical value = raw x scale. A measurement that its signal cannot
carry is sent as invalid or not at all, never saturated.

Timeout: after so long without the frame its receiver treats the sender as lost.
"""
FD_HEAD = """
## CAN FD

With bit rate switch, 1 Mbit/s nominal and 5 Mbit/s data.

End-to-end protection: AUTOSAR E2E Profile 5. Byte 0 and 1: CRC-16 (0x1021, start 0xFFFF, low byte first) over the rest of the frame
and the Data ID of the table; byte 2: a counter per frame. A receiver refuses a wrong CRC, a repetition, and {max_delta}
frames lost in a row or more; frames that are sent on events are taken whatever number of them was lost.
"""
CLASSIC_HEAD = """
## Classic CAN

1 Mbit/s, frames of up to 8 bytes. The same messages, short ones in one frame, long ones in parts, whose counters are equal: parts
with other counters, or further apart than the timeout, are not put together, so that no message is ever torn. FirmwareHeartbeat is
the same as on CAN FD.

End-to-end protection: AUTOSAR E2E Profile 2. Byte 0: CRC-8 (0x2F, start and final XOR 0xFF) over the rest of the frame and the
Data ID; low half of byte 1: a counter per message, 0 to 15. The Data ID is one of 16, by the counter n: that of the table + 16 n,
modulo 256 (Profile 2's DataIDList). A receiver refuses a wrong CRC, a repetition, and {classic_max_delta} frames lost in a row or more.

It is weaker than CAN FD's. One damaged frame in 256 has a right CRC (Profile 5: in 65,536). A frame that comes 16 messages late has
the counter of a new one. And a pose's stamp has 8 bits of 1.024 ms: of the way from the tracker to the firmware, a delay that grows
by more than 131 ms from one pose to the next does not show in the pose's age, where CAN FD's 32 bits of 1 us show any. Receive
timeouts hold in either profile.
"""
JOINT = re.compile(r"_\d(?=_|$)")


def attribute(message: Message, name: str) -> int:
    found = message.dbc.attributes.get(name) if message.dbc else None
    return int(found.value) if found else 0


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    return [
        "| " + " | ".join(header) + " |",
        "|---" * len(header) + "|",
        *("| " + " | ".join(row) + " |" for row in rows),
    ]


def number(value: float) -> str:
    return f"{int(value)}" if float(value).is_integer() else f"{float(value):.9g}"


def scale_text(scale: float) -> str:
    """A negative power of two as a fraction, so that no digits are lost."""
    inverse = round(1.0 / scale)
    is_binary = inverse > 1 and inverse & (inverse - 1) == 0 and scale * inverse == 1.0
    return f"1/{inverse}" if is_binary else number(scale)


def families(messages: Iterable[Message]) -> list[list[Message]]:
    """Messages in the order of their ids; those whose names differ in a last digit only are one family."""
    found: dict[str, list[Message]] = {}
    for message in sorted(messages, key=lambda m: m.frame_id):
        found.setdefault(message.name.rstrip("0123456789"), []).append(message)
    return list(found.values())


def family_name(family: Sequence[Message]) -> str:
    last = family[-1].name[len(family[0].name.rstrip("0123456789")) :]
    return family[0].name + (f"..{last}" if len(family) > 1 else "")


def hexadecimal(family: Sequence[Message], value: str) -> str:
    """Of the first and the last: "0x180..0x187"."""
    values = {"id": [m.frame_id for m in family], "data_id": [attribute(m, "E2EDataId") for m in family]}[value]
    if not any(values):
        return "none"
    texts = [f"0x{v:03X}" if value == "id" else f"0x{v:04X}" for v in (values[0], values[-1])]
    return "..".join(dict.fromkeys(texts))


def overview_row(family: Sequence[Message]) -> list[str]:
    message = family[0]
    receivers = ", ".join(sorted(message.receivers)) or "-"
    period, timeout = message.cycle_time or 0, attribute(message, "TimeoutMs")
    return [
        hexadecimal(family, "id"),
        f"[{family_name(family)}](#{family_name(family).lower().replace('.', '')})",
        str(message.length),
        f"{period} ms" if period else "on events",
        f"{timeout} ms" if timeout else "-",
        hexadecimal(family, "data_id"),
        ", ".join(message.senders),
        receivers,
    ]


def signal_row(signal: Signal, is_repeated: bool) -> list[str]:
    kind = "float32" if signal.is_float else f"{'s' if signal.is_signed else 'u'}{signal.length}"
    scale = "" if signal.is_float or float(signal.scale) == 1.0 else scale_text(float(signal.scale))
    values = ", ".join(f"{value} {name}" for value, name in sorted((signal.choices or {}).items()))
    if signal.name == "parameter":
        values = "a number of [parameters.md](parameters.md)"
    span = values or f"{number(signal.minimum)} to {number(signal.maximum)}"
    if signal.comment:
        span += f". {signal.comment}" if not is_repeated else f". {signal.comment} (of each joint)"
    name = JOINT.sub("_N", signal.name) if is_repeated else signal.name
    return [f"`{name}`", str(signal.start), kind, scale, signal.unit or "", span]


def signal_rows(message: Message) -> list[list[str]]:
    """Of signals that repeat per joint, joint 0's, under the name with N."""
    names = [JOINT.sub("_N", signal.name) for signal in message.signals]
    rows = []
    for signal, name in zip(message.signals, names, strict=True):
        is_repeated = names.count(name) > 1
        if not signal.name.startswith("e2e_") and not (is_repeated and JOINT.search(signal.name)[0] != "_0"):
            rows.append(signal_row(signal, is_repeated))
    return rows


def per_joint_note(message: Message) -> list[str]:
    first = {s.name: s.start for s in message.signals}
    pairs = [(s.start, first[JOINT.sub("_1", s.name)]) for s in message.signals if JOINT.search(s.name)
             and JOINT.search(s.name)[0] == "_0" and JOINT.sub("_1", s.name) in first]  # fmt: skip
    steps = {b - a for a, b in pairs}
    if not pairs:
        return []
    assert len(steps) == 1, f"{message.name}: joints are not equally far apart"
    count = 1 + max(int(JOINT.search(s.name)[0][1:]) for s in message.signals if JOINT.search(s.name))
    return ["", f"N = 0 to {count - 1}; from one joint to the next the start bit grows by {steps.pop()}."]


def section(family: Sequence[Message]) -> list[str]:
    message = family[0]
    comment = message.comment or ""
    if len(family) > 1:
        comment = re.sub(r"(\w+) 0\b", r"\1 N", comment)
    header = ("signal", "start bit", "raw", "scale", "unit", "range or values")
    return ["", f"### {family_name(family)}", "", comment + ".", "",
            *table(header, signal_rows(message)), *per_joint_note(message)]  # fmt: skip


def markdown(database: cantools.database.Database, max_delta: int, classic_max_delta: int) -> str:
    """The whole text. `max_delta`, `classic_max_delta`: of E2E counters, as the firmware has them."""
    fd = families(message for message in database.messages if not is_classic(message.name))
    classic = families(message for message in database.messages if is_classic(message.name))
    header = ("id", "frame", "bytes", "period", "timeout", "E2E Data ID", "sent by", "for")
    lines = [HEAD]
    for head, groups in ((FD_HEAD, fd), (CLASSIC_HEAD, classic)):
        lines += [head.lstrip("\n").format(max_delta=max_delta, classic_max_delta=classic_max_delta)]
        lines += table(header, (overview_row(group) for group in groups))
        for group in groups:
            lines += section(group)
        lines += [""]
    return "\n".join(lines).rstrip("\n") + "\n"


def max_delta(name: str) -> int:
    """Of firmware/protocol/e2e.h: how far a counter may be ahead."""
    text = (REPOSITORY / "firmware" / "protocol" / "e2e.h").read_text()
    return int(re.search(rf"#define {name} (\d+)", text)[1])


def main(argv: Sequence[str]) -> int:
    if len(argv) > 1:
        print("usage: python -m comanip_dev.bus.doc [FILE]", file=sys.stderr)
        return 2
    text = markdown(
        cantools.database.load_file(DBC_PATH), max_delta("E2E_MAX_DELTA"), max_delta("E2E_PROFILE2_MAX_DELTA")
    )
    if not argv:
        sys.stdout.write(text)
        return 0
    path = Path(argv[0])
    unfinished = path.with_name(path.name + ".part")
    unfinished.write_text(text)
    unfinished.replace(path)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
