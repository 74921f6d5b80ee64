"""Generates the firmware's CAN sources from comanip.dbc, the one place where frames are described.

Run as ``python -m comanip_dev.codegen OUT_DIR``. Writes:

``comanip_dbc.h/.c``
    cantools' structs with pack/unpack of *raw integers*. Its encode, decode and range functions are left out: they
    convert out-of-range floats (undefined behaviour in C) and pull in double arithmetic; ``firmware/protocol/can_protocol.c``
    scales and range-checks instead. Packing writes each byte once, not zeros first. The generation date is dropped, so that a build is reproducible.
``comanip_schema.h``
    what cantools does not emit: E2E Data IDs, timeouts, scale factors, raw ranges, the names of enumerated values, and
    one X-macro row per frame, for CAN FD and for classic CAN.
``comanip_build_hash.h``
    64 bits of SHA-256 over the firmware's sources and the DBC. The same sources have the same hash on the host and on
    every target, so a log of one can be replayed on another.

A file that would not change is left alone, so that make rebuilds only what it must.
"""

from __future__ import annotations

import hashlib
import re
import sys
from pathlib import Path

import cantools
from cantools.database.can.c_source import camel_to_snake_case, generate
from cantools.database.can.message import Message

from comanip_dev import REPOSITORY

DBC_PATH = REPOSITORY / "host_tools" / "comanip" / "comanip.dbc"
FIRMWARE = REPOSITORY / "firmware"
CLASSIC = "Classic"  # names of the frames for classic CAN begin so
UNWANTED = r"(?:init|encode|decode|is_in_range|is_in_phys_range)"


def drop_unwanted_functions(text: str) -> str:
    """Removes declarations and definitions of every function but pack and unpack, each with its doc comment."""
    signature = rf"(?:/\*\*(?:(?!\*/).)*?\*/\n)?(?:int|bool|double|int\d+_t|uint\d+_t) comanip_\w+_{UNWANTED}\([^)]*\)"
    text = re.sub(signature + r"\n\{\n.*?\n\}\n", "", text, flags=re.DOTALL)
    return re.sub(signature + r";\n", "", text, flags=re.DOTALL)


def write_each_byte_once(text: str) -> str:
    """Packing begins with zeros in all bytes, into which each signal is ored: the first of a byte is written instead. For straight-line
    code, which it is unless signals are multiplexed."""

    def rewritten(match: re.Match) -> str:
        body, seen = match["body"], set()
        if "switch" in body:
            raise SystemExit(
                "codegen: a message has multiplexed signals, expected none: each byte of a frame is written in any case"
            )

        def first(write: re.Match) -> str:
            again = write["byte"] in seen
            seen.add(write["byte"])
            return write[0] if again else write[0].replace("|=", "=")

        body = re.sub(r"dst_p\[(?P<byte>\d+)\] \|=", first, body)
        empty = [f"    dst_p[{byte}] = 0u;\n" for byte in range(int(match["size"])) if str(byte) not in seen]
        return "".join(empty) + body

    return re.sub(
        r"    memset\(&dst_p\[0\], 0, (?P<size>\d+)\);\n(?P<body>.*?)(?=\n    return )",
        rewritten,
        text,
        flags=re.DOTALL,
    )


def raw_limits(signal) -> tuple[int, int]:
    if signal.is_signed:
        return -(2 ** (signal.length - 1)), 2 ** (signal.length - 1) - 1
    return 0, 2**signal.length - 1


RAW_MAX = 2**23  # quantise() in firmware/protocol/can_protocol.c: adds half in float32


def names_by_value(signal) -> str:
    """Designated initialisers of an array of strings: the value table of an enumerated signal."""
    return ", ".join(f'[{value}] = "{name}"' for value, name in sorted(signal.choices.items()))


def attribute(message: Message, name: str) -> int:
    found = message.dbc.attributes.get(name) if message.dbc else None
    return int(found.value) if found else 0


def check_joints_are_alike(messages: list[Message], prefix: str) -> None:
    """One codec serves the eight frames `prefix`0..7, so their layouts must be the same."""
    layouts = {
        message.name: [(s.name, s.start, s.length, s.is_signed, s.scale) for s in message.signals]
        for message in messages
        if re.fullmatch(prefix + r"\d", message.name)
    }
    reference = layouts[prefix + "0"]
    for name, layout in layouts.items():
        if layout != reference:
            raise SystemExit(f"codegen: {name} has another layout than {prefix}0: one codec serves all eight")


def check_joints_are_scaled_alike(message: Message) -> None:
    """One loop serves the joints' signals NAME_0_UNIT..NAME_7_UNIT of JointCmd."""
    scaling: dict[str, tuple] = {}
    for signal in message.signals:
        own = (signal.length, signal.is_signed, signal.scale)
        if scaling.setdefault(re.sub(r"_\d(?=_|$)", "", signal.name), own) != own:
            raise SystemExit(
                f"codegen: {message.name}: {signal.name} is scaled otherwise than joint 0's: one loop serves all eight"
            )


def frame_rows(messages: list[Message]) -> list[str]:
    return [
        f"    FRAME({camel_to_snake_case(m.name).upper()}, 0x{m.frame_id:03X}u, {m.length}u, "
        f"0x{attribute(m, 'E2EDataId'):04X}u, {m.cycle_time or 0}u, {attribute(m, 'TimeoutMs')}u, "
        f"{str('Firmware' in m.receivers).lower()})"
        for m in messages
    ]


def x_macro(name: str, rows: list[str]) -> list[str]:
    return [f"#define {name}(FRAME) \\", *(row + " \\" for row in rows[:-1]), rows[-1], ""]


def schema_header(database) -> str:
    lines = [
        "/* Generated from comanip.dbc by codegen.py: do not edit. */",
        "#ifndef COMANIP_SCHEMA_H",
        "#define COMANIP_SCHEMA_H",
        "",
        "/* FRAME(NAME, id, bytes, E2E Data ID (0 = unprotected), period in ms (0 = event), timeout in ms (0 = none),",
        " *       whether the firmware receives it) */",
        *x_macro("COMANIP_FRAMES", frame_rows([m for m in database.messages if not m.name.startswith(CLASSIC)])),
        *x_macro("COMANIP_CLASSIC_FRAMES", frame_rows([m for m in database.messages if m.name.startswith(CLASSIC)])),
        "/* Physical value = raw * RESOLUTION = raw / PER_UNIT; raw within RAW_MIN..RAW_MAX. Signals in plain counts have none.",
        " * NAMES: initialisers of an array of an enumerated signal's names. */",
    ]
    for message in database.messages:
        for signal in message.signals:
            if signal.name.startswith("e2e_") or signal.is_float:
                continue
            prefix = f"COMANIP_{camel_to_snake_case(message.name).upper()}_{signal.name.upper()}"
            low, high = raw_limits(signal)
            if float(signal.scale) != 1.0 and max(abs(low), abs(high)) > RAW_MAX:
                raise SystemExit(
                    f"codegen: {message.name}.{signal.name}: raw values to {max(abs(low), abs(high))}, expected at most {RAW_MAX}"
                )
            if signal.choices:
                lines.append(f"#define {prefix}_NAMES {names_by_value(signal)}")
            if float(signal.scale) == 1.0:
                continue
            lines.append(f"#define {prefix}_RESOLUTION {float(signal.scale)!r}f")
            lines.append(f"#define {prefix}_PER_UNIT {float(round(1.0 / float(signal.scale), 6))!r}f")
            lines.append(f"#define {prefix}_RAW_MIN ({low})")
            lines.append(f"#define {prefix}_RAW_MAX ({high})")
    return "\n".join([*lines, "", "#endif", ""])


def build_hash_header() -> str:
    digest = hashlib.sha256()
    for path in [DBC_PATH, *sorted(FIRMWARE.rglob("*.[ch]"))]:
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return (
        "/* Generated by codegen.py: do not edit. */\n"
        "#ifndef COMANIP_BUILD_HASH_H\n#define COMANIP_BUILD_HASH_H\n\n"
        f"#define COMANIP_BUILD_HASH 0x{digest.hexdigest()[:16]}ull\n\n#endif\n"
    )


def write_if_changed(path: Path, text: str) -> None:
    if not path.exists() or path.read_text() != text:
        path.write_text(text)


def main(out_dir: Path) -> None:
    database = cantools.database.load_file(DBC_PATH)
    for prefix in ("JointState", CLASSIC + "JointState", CLASSIC + "JointCmd"):
        check_joints_are_alike(database.messages, prefix)
    check_joints_are_scaled_alike(database.get_message_by_name("JointCmd"))
    header, source, _, _ = generate(
        database, "comanip", "comanip_dbc.h", "comanip_dbc.c", "unused.c", floating_point_numbers=False
    )
    out_dir.mkdir(parents=True, exist_ok=True)
    for name, text in (("comanip_dbc.h", header), ("comanip_dbc.c", source)):
        text = re.sub(r"(This \w+ file was generated by cantools version \S+?)\.? .*", r"\1", text)
        write_if_changed(out_dir / name, write_each_byte_once(drop_unwanted_functions(text)))
    write_if_changed(out_dir / "comanip_schema.h", schema_header(database))
    write_if_changed(out_dir / "comanip_build_hash.h", build_hash_header())


if __name__ == "__main__":
    if len(sys.argv) != 2:
        raise SystemExit("usage: python -m comanip_dev.codegen OUT_DIR")
    main(Path(sys.argv[1]))
