"""Generates C sources of the firmware from the schema, firmware/schema/, which describes frames, parameters and tasks.

Run as ``python -m comanip_dev.codegen OUT_DIR``. Raises SystemExit if the schema is inconsistent. Writes:

``comanip_dbc.h/.c``
    cantools' structs, with pack and unpack functions for *raw integers*. cantools' encode, decode and range functions
    are removed, because they convert out-of-range floats (undefined behaviour in C) and need double arithmetic.
    comanip_messages does the scaling and the range checks instead. Packing writes each byte once instead of clearing
    the payload first. The generation date is removed, so that the build is reproducible.
``comanip_schema.h``
    data of the DBC that cantools does not emit: E2E Data IDs, timeouts, scale factors, raw ranges, the names of
    enumerated values, and one X-macro row per frame, for CAN FD and for classic CAN.
``comanip_messages.h/.inc``, ``comanip_classic.inc``, ``comanip_parameters.h``, ``comanip_tasks.h``
    see messages.py, classic.py, tables.py.
``comanip_identity.h``
    the contents of FirmwareIdentity: the build hash, the trace version and the trace hash. The build hash is 64 bits of
    SHA-256 over the firmware's sources and the schema. It is therefore the same on the host and on every target. A log
    can be replayed only by a core with the same trace version and trace hash.

``python -m comanip_dev.codegen --schema`` (``make schema``) updates the rows of comanip.dbc that repeat parameters and
tasks. A file whose contents would not change is not rewritten, so that make does not rebuild its dependents.
"""

from __future__ import annotations

import hashlib
import re
import sys
from pathlib import Path

import cantools
from cantools.database.can.c_source import camel_to_snake_case, generate
from cantools.database.can.message import Message
from comanip import parameters, tasks
from comanip.errors import ToolError

from comanip_dev import REPOSITORY
from comanip_dev.schema import classic as classic_codec
from comanip_dev.schema import messages as message_codec
from comanip_dev.schema import tables
from comanip_dev.schema.signals import CLASSIC, attribute, raw_limits

FIRMWARE = REPOSITORY / "firmware"
SCHEMA = FIRMWARE / "schema"
DBC_PATH = SCHEMA / "comanip.dbc"
UNWANTED = r"(?:init|encode|decode|is_in_range|is_in_phys_range)"


def drop_unwanted_functions(text: str) -> str:
    """Removes the declarations, definitions and doc comments of all functions except pack and unpack."""
    signature = rf"(?:/\*\*(?:(?!\*/).)*?\*/\n)?(?:int|bool|double|int\d+_t|uint\d+_t) comanip_\w+_{UNWANTED}\([^)]*\)"
    text = re.sub(signature + r"\n\{\n.*?\n\}\n", "", text, flags=re.DOTALL)
    return re.sub(signature + r";\n", "", text, flags=re.DOTALL)


def write_each_byte_once(text: str) -> str:
    """Changes cantools' packing, which clears all bytes and then combines the signals with OR: the first OR into each
    byte becomes an assignment. The replacement requires straight-line code, so messages with multiplexed signals, which
    need a `switch`, are refused."""

    def rewritten(match: re.Match) -> str:
        body, seen = match["body"], set()
        if "switch" in body:
            raise SystemExit("codegen: a message has multiplexed signals, expected none")

        def first(write: re.Match) -> str:
            again = write["byte"] in seen
            seen.add(write["byte"])
            return write[0] if again else write[0].replace("|=", "=")

        body = re.sub(r"dst_p\[(?P<byte>\d+)\] \|=", first, body)
        empty = [f"    dst_p[{byte}] = 0u;\n" for byte in range(int(match["size"])) if str(byte) not in seen]
        return "".join(empty) + body

    whole = r"    memset\(&dst_p\[0\], 0, (?P<size>\d+)\);\n(?P<body>.*?)(?=\n    return )"
    return re.sub(whole, rewritten, text, flags=re.DOTALL)


RAW_MAX = 2**23  # above it, adding 0.5 in float32 is inexact (quantise() in messages.c)


def names_by_value(signal) -> str:
    """Returns the value table of an enumerated signal as designated initialisers of an array of strings."""
    return ", ".join(f'[{value}] = "{name}"' for value, name in sorted(signal.choices.items()))


# ---- consistency of the schema


def check_joints_are_alike(messages: list[Message], prefix: str) -> None:
    """Checks that the eight frames `prefix`0..7 have the same layout, because they share one codec."""
    layouts = {
        message.name: [(s.name, s.start, s.length, s.is_signed, s.scale) for s in message.signals]
        for message in messages
        if re.fullmatch(prefix + r"\d", message.name)
    }
    reference = layouts[prefix + "0"]
    for name, layout in layouts.items():
        if layout != reference:
            raise SystemExit(f"codegen: {name}: expected the layout of {prefix}0, because one codec serves all eight")


def check_joints_are_scaled_alike(message: Message) -> None:
    """Checks that the signals NAME_0_UNIT..NAME_7_UNIT of JointCmd have the same scale and length, because one loop
    packs them all."""
    scaling: dict[str, tuple] = {}
    for signal in message.signals:
        own = (signal.length, signal.is_signed, signal.scale)
        if scaling.setdefault(re.sub(r"_\d(?=_|$)", "", signal.name), own) != own:
            raise SystemExit(f"codegen: {message.name}.{signal.name}: expected the length and scale of joint 0")


def check_classic_tables(messages: list[Message]) -> None:
    """Checks that each signal has the same value table in both profiles."""
    parts = classic_codec.parts_of(messages)
    for message in messages:
        own = {signal.name: signal.choices for signal in message.signals if signal.choices}
        for part in parts.get(message.name, []):
            for signal in part.signals:
                if signal.name in own and signal.choices != own[signal.name]:
                    raise SystemExit(f"codegen: {part.name}.{signal.name}: expected the value table of {message.name}")


def check_readers(messages: list[Message]) -> None:
    """Checks that each frame has a sender and a receiver among the DBC's nodes."""
    for message in messages:
        if not message.senders or not message.receivers:
            raise SystemExit(
                f"codegen: {message.name}: no {'reader' if message.senders else 'sender'}, expected a node of BU_"
            )


def check_data_ids(messages: list[Message]) -> None:
    """Checks that no two frames of a profile share a Data ID, because one could then be mistaken for the other."""
    used: dict[tuple[bool, int], str] = {}
    for message in messages:
        data_id = attribute(message, "E2EDataId")
        other = used.setdefault((message.name.startswith(CLASSIC), data_id), message.name)
        if data_id and other != message.name:
            raise SystemExit(f"codegen: {message.name}: E2EDataId {data_id} is already used by {other}")


def check_trace(messages: list[Message]) -> None:
    """Checks that TickTrace has a counter, and a bit in `received`, for each frame that the firmware receives."""
    trace = next(message for message in messages if message.name == "TickTrace")
    counters = [s.name for s in trace.signals if s.name.endswith("_counter") and not s.name.startswith("e2e_")]
    expected = [trace_counter(message) for message in to_firmware(messages)]
    if sorted(counters) != sorted(expected) or trace.get_signal_by_name("received").length != len(counters):
        raise SystemExit(
            f"codegen: TickTrace has counters of {', '.join(counters)}; the firmware receives {', '.join(expected)}"
        )


def to_firmware(messages: list[Message]) -> list[Message]:
    """Returns the CAN FD messages that the firmware receives."""
    return [m for m in messages if "Firmware" in m.receivers and not m.name.startswith(CLASSIC)]


def trace_counter(message: Message) -> str:
    """Returns the name of a message's counter in TickTrace, such as hand_pose_counter, or joint_state_3_counter for
    JointState3."""
    return re.sub(r"(\D)(\d)$", r"\1_\2", camel_to_snake_case(message.name)) + "_counter"


# ---- headers


def frame_rows(messages: list[Message]) -> list[str]:
    return [
        f"    FRAME({camel_to_snake_case(m.name).upper()}, 0x{m.frame_id:03X}u, {m.length}u, "
        f"0x{attribute(m, 'E2EDataId'):04X}u, {m.cycle_time or 0}u, {attribute(m, 'TimeoutMs')}u, "
        f"{str('Firmware' in m.receivers).lower()})"
        for m in messages
    ]


def x_macro(name: str, rows: list[str]) -> list[str]:
    return [f"#define {name} \\", *(row + " \\" for row in rows[:-1]), rows[-1], ""]


def trace_rows(messages: list[Message]) -> list[str]:
    """Returns the rows in the order of the counters in TickTrace, which is also the order of the bits in `received`."""
    trace = next(message for message in messages if message.name == "TickTrace")
    by_counter = {trace_counter(m): m for m in to_firmware(messages)}
    rows = []
    for signal in trace.signals:
        if signal.name in by_counter:
            member = re.sub(r"^(.*)_(\d)_counter$", r"\1_counter[\2]", signal.name)
            rows.append(f"    COUNTER({camel_to_snake_case(by_counter[signal.name].name).upper()}, {member})")
    return rows


def received_rows(messages: list[Message]) -> list[str]:
    return [
        f"    RECEIVED({camel_to_snake_case(m.name).upper()}, {message_codec.codec_name(m)})"
        for m in to_firmware(messages)
    ]


def multipart_rows(messages: list[Message]) -> list[str]:
    """Returns the rows for messages that consist of several frames on classic CAN."""
    long = [name for name, parts in classic_codec.parts_of(messages).items() if len(parts) > 1]
    return [f"    KIND({camel_to_snake_case(name).upper()}, {i})" for i, name in enumerate(long)]


def schema_header(database) -> str:
    fd = [m for m in database.messages if not m.name.startswith(CLASSIC)]
    classic = [m for m in database.messages if m.name.startswith(CLASSIC)]
    lines = [
        message_codec.GENERATED,
        "#ifndef COMANIP_SCHEMA_H",
        "#define COMANIP_SCHEMA_H",
        "",
        "/* FRAME(NAME, id, bytes, E2E Data ID (0 = unprotected), period in ms (0 = event), timeout in ms (0 = none),",
        " *       whether the firmware receives it) */",
        *x_macro("COMANIP_FRAMES(FRAME)", frame_rows(fd)),
        *x_macro("COMANIP_CLASSIC_FRAMES(FRAME)", frame_rows(classic)),
        "/* RECEIVED(NAME, name of its struct without _t): frames that the firmware receives */",
        *x_macro("COMANIP_RECEIVED(RECEIVED)", received_rows(database.messages)),
        "/* COUNTER(NAME, member of tick_trace_t): frames that the firmware receives, in the order of",
        " * TickTrace.received */",
        *x_macro("COMANIP_TRACED(COUNTER)", trace_rows(database.messages)),
        "/* KIND(NAME, index): messages that have several frames on classic CAN */",
        *x_macro("COMANIP_MULTIPART(KIND)", multipart_rows(database.messages)),
        f"#define COMANIP_MULTIPART_COUNT {len(multipart_rows(database.messages))}",
        "",
        "/* Physical value = raw * RESOLUTION = raw / PER_UNIT; raw is within RAW_MIN..RAW_MAX. Signals of scale 1",
        " * have none of these. NAMES: initialisers of an array with the names of an enumerated signal. BYTE: index of",
        " * the first byte of a 32-bit signal, or of the byte with a flag. */",
    ]
    for message in database.messages:
        for signal in message.signals:
            if signal.name.startswith("e2e_") or signal.is_float:
                continue
            prefix = f"COMANIP_{camel_to_snake_case(message.name).upper()}_{signal.name.upper()}"
            low, high = raw_limits(signal)
            if float(signal.scale) != 1.0 and max(abs(low), abs(high)) > RAW_MAX:
                most = max(abs(low), abs(high))
                raise SystemExit(
                    f"codegen: {message.name}.{signal.name}: raw values to {most}, expected at most {RAW_MAX}"
                )
            if signal.length == 32 and signal.start % 8 == 0 and signal.byte_order == "little_endian":
                lines.append(f"#define {prefix}_BYTE {signal.start // 8}")
            if signal.length == 1:
                lines.append(f"#define {prefix}_BYTE {signal.start // 8}")
                lines.append(f"#define {prefix}_MASK 0x{1 << signal.start % 8:02X}u")
            if signal.choices:
                lines.append(f"#define {prefix}_NAMES {names_by_value(signal)}")
            if float(signal.scale) == 1.0:
                continue
            lines.append(f"#define {prefix}_RESOLUTION {float(signal.scale)!r}f")
            lines.append(f"#define {prefix}_PER_UNIT {float(round(1.0 / float(signal.scale), 6))!r}f")
            lines.append(f"#define {prefix}_RAW_MIN ({low})")
            lines.append(f"#define {prefix}_RAW_MAX ({high})")
    return "\n".join([*lines, "", "#endif", ""])


def trace_hash(database) -> int:
    """Returns 32 bits of SHA-256 over what a replay depends on: the trace version, and the layouts of TickTrace and of
    the frames that the firmware receives, on CAN FD and classic CAN."""
    parts = classic_codec.parts_of(database.messages)
    names = [m.name for m in to_firmware(database.messages)] + ["TickTrace"]
    names += [part.name for name in names for part in parts.get(name, [])]
    layouts = []
    for name in sorted(names):
        message = database.get_message_by_name(name)
        signals = sorted(
            (s.name, s.start, s.length, float(s.scale), float(s.offset), s.is_signed, s.is_float)
            for s in message.signals
        )
        layouts.append((name, message.frame_id, message.length, attribute(message, "E2EDataId"), signals))
    return int(hashlib.sha256(repr((trace_version(database), layouts)).encode()).hexdigest()[:8], 16)


def trace_version(database) -> int:
    return int(database.dbc.attributes["TraceVersion"].value)


def identity_header(database, schema: Path) -> str:
    digest = hashlib.sha256()
    for path in [*sorted(schema.iterdir()), *sorted(FIRMWARE.rglob("*.[ch]"))]:
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return (
        f"{message_codec.GENERATED}\n"
        "#ifndef COMANIP_IDENTITY_H\n#define COMANIP_IDENTITY_H\n\n"
        f"#define COMANIP_BUILD_HASH 0x{digest.hexdigest()[:16]}ull\n"
        f"#define COMANIP_TRACE_VERSION {trace_version(database)}u\n"
        f"#define COMANIP_TRACE_HASH 0x{trace_hash(database):08x}u\n\n#endif\n"
    )


# ---- files


def write_if_changed(path: Path, text: str) -> None:
    if not path.exists() or path.read_text() != text:
        path.write_text(text)


def dbc_sources(database) -> dict[str, str]:
    header, source, _, _ = generate(
        database, "comanip", "comanip_dbc.h", "comanip_dbc.c", "unused.c", floating_point_numbers=False
    )
    texts = {"comanip_dbc.h": header, "comanip_dbc.c": source}
    for name, text in texts.items():
        dated = re.sub(r"(This \w+ file was generated by cantools version \S+?)\.? .*", r"\1", text)
        texts[name] = write_each_byte_once(drop_unwanted_functions(dated))
    return texts


def check(database) -> None:
    for prefix in ("JointState", CLASSIC + "JointState", CLASSIC + "JointCmd"):
        check_joints_are_alike(database.messages, prefix)
    check_joints_are_scaled_alike(database.get_message_by_name("JointCmd"))
    check_readers(database.messages)
    check_data_ids(database.messages)
    check_trace(database.messages)
    check_classic_tables(database.messages)


def main(out_dir: Path, schema: Path = SCHEMA) -> None:
    """Writes the sources into out_dir. Raises SystemExit if the schema is inconsistent."""
    try:
        all_parameters, all_tasks = parameters.read(schema / "parameters.toml"), tasks.read(schema / "tasks.toml")
    except ToolError as error:
        raise SystemExit(f"codegen: {error}") from error
    dbc = (schema / "comanip.dbc").read_text()
    if tables.dbc_with_tables(dbc, all_parameters, all_tasks) != dbc:
        raise SystemExit(
            f"codegen: {schema}/comanip.dbc: the names or ranges differ from parameters.toml or tasks.toml: "
            "update it with `make schema`"
        )
    database = cantools.database.load_string(dbc, "dbc")
    check(database)
    texts = dbc_sources(database) | {
        "comanip_schema.h": schema_header(database),
        "comanip_messages.h": message_codec.header(database.messages),
        "comanip_messages.inc": message_codec.bodies(database.messages),
        "comanip_classic.inc": classic_codec.bodies(database.messages),
        "comanip_parameters.h": tables.parameters_header(all_parameters),
        "comanip_tasks.h": tables.tasks_header(all_tasks),
        "comanip_identity.h": identity_header(database, schema),
    }
    out_dir.mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        write_if_changed(out_dir / name, text)


def update_schema(schema: Path = SCHEMA) -> None:
    """Updates the rows of comanip.dbc that repeat parameters and tasks."""
    path = schema / "comanip.dbc"
    try:
        own = parameters.read(schema / "parameters.toml"), tasks.read(schema / "tasks.toml")
    except ToolError as error:
        raise SystemExit(f"codegen: {error}") from error
    write_if_changed(path, tables.dbc_with_tables(path.read_text(), *own))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        raise SystemExit("usage: codegen.py OUT_DIR | --schema")
    if sys.argv[1] == "--schema":
        update_schema()
    else:
        main(Path(sys.argv[1]))
