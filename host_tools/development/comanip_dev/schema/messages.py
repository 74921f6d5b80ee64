"""Generates C structs for messages in SI units, and the functions that pack them into CAN FD frames and unpack them.

``comanip_messages.h`` contains an enumeration for each value table with the attribute EnumType, a struct for each
message, and the functions ``X_pack(message, frame)`` and ``X_unpack(frame, message)``. ``comanip_messages.inc``, which
is included by firmware/protocol/messages.c, contains the bodies of these functions. Messages NAME0..NAME7
with equal layouts share one struct, and their functions take the joint's number. signals.py determines which signals
form one member.
"""

from __future__ import annotations

import re
import textwrap

from cantools.database.can.message import Message
from cantools.database.can.signal import Signal

from comanip_dev.schema.signals import (
    AXES,
    CLASSIC,
    JOINTS,
    QUATERNION,
    Group,
    Layout,
    attribute,
    constant,
    integer_bits,
    is_header,
    layout,
    lower,
    raw_limits,
    raw_type,
    snake,
)

GENERATED = "/* Generated from firmware/schema/ by `make`: do not edit. */"
COLUMNS = 120


def wrapped(text: str, indent: str = "") -> list[str]:
    """Formats the text as a C comment within 120 columns."""
    lines = textwrap.wrap(text, COLUMNS - len(indent) - 6)
    return [f"{indent}{'/* ' if i == 0 else ' * '}{line}" for i, line in enumerate(lines[:-1])] + [
        f"{indent}{'/* ' if len(lines) == 1 else ' * '}{lines[-1]} */"
    ]


# ---- messages and their codecs


def family(message: Message) -> str | None:
    """Returns the common name of the messages that share one codec (JointState for JointState0..7), or None."""
    match = re.fullmatch(r"(\w*\D)\d", message.name)
    return match[1] if match else None


def leads(message: Message) -> bool:
    """Returns True if the message is the only one with its codec, or the first of several."""
    return family(message) is None or message.name.endswith("0")


def codec_name(message: Message) -> str:
    """Returns the name of a message's codec, such as hand_pose or joint_state."""
    return re.sub(r"\d$", "", snake(message))


# ---- enumerations


def enumeration(signal: Signal) -> tuple[str, str, bool] | None:
    """Returns (enumeration type, prefix of its values, True if the struct's member has this type), or None if
    the signal has no enumeration."""
    words = str(attribute(signal, "EnumType", "")).split()
    if not words:
        return None
    if len(words) not in (2, 3) or words[2:] not in ([], ["number"]) or not signal.choices:
        raise SystemExit(
            f"codegen: {signal.name}: EnumType '{' '.join(words)}': expected 'TYPE PREFIX [number]' and a value table"
        )
    return words[0], words[1], len(words) == 2


def enumerations(messages: list[Message]) -> list[str]:
    found: dict[str, tuple[str, dict[int, str]]] = {}
    for message in messages:
        for signal in message.signals:
            if enumeration(signal) is None:
                continue
            name, prefix, _ = enumeration(signal)
            choices = {int(value): str(text) for value, text in signal.choices.items()}
            if found.setdefault(name, (prefix, choices)) != (prefix, choices):
                raise SystemExit(
                    f"codegen: {message.name}.{signal.name}: expected the same value table as other signals of {name}"
                )
    lines = []
    for name, (prefix, choices) in found.items():
        values = [f"    {prefix}_{text.upper()} = {value}," for value, text in sorted(choices.items())]
        lines += ["typedef enum {", *values, f"}} {name};", ""]
    return lines


# ---- structs


def scalar_type(signal: Signal) -> str:
    kind = enumeration(signal)
    if kind and kind[2]:
        return kind[0]
    if signal.is_float:
        return "float"
    if float(signal.scale) not in (1.0, 10.0):
        return "float"
    if signal.length == 1:
        return "bool"
    largest = raw_limits(signal)[1] * int(signal.scale)
    return f"{'int' if signal.is_signed else 'uint'}{integer_bits(signal, largest if signal.scale != 1 else None)}_t"


def members(found: Layout) -> list[str]:
    lines, poses = [], set()
    for group in found.groups:
        comment = f" /* {group.first.comment} */" if group.first.comment else ""
        if group.base in found.poses:
            declaration = "" if group.base in poses else f"pose_t {group.base};"
            poses.add(group.base)
        elif group.kind in ("vector", "quaternion"):
            declaration = f"{group.kind}{'3' if group.kind == 'vector' else ''}_t {group.member};"
        else:
            size = f"[{JOINTS}]" if group.kind == "array" else ""
            declaration = f"{scalar_type(group.first)} {group.member}{size};"
        if declaration and len(declaration) + len(comment) > COLUMNS - 4:
            lines += [*wrapped(group.first.comment, "    "), f"    {declaration}"]
        elif declaration:
            lines.append(f"    {declaration}{comment}")
    return lines


# ---- packing


def pack_value(message: Message, signal: Signal, value: str, fits: str) -> list[str]:
    """Returns the statements that write a C value to the raw struct."""
    raw = f"raw.{lower(signal)}"
    kind = scalar_type(signal)
    if kind == "float" and not signal.is_float:
        return [f"    PACK({fits}, {value}, {constant(message, signal)}, {raw_type(signal)}, {raw});"]
    if kind == "float" or kind == "bool":
        return [f"    {raw} = {value};"]
    step, most = int(signal.scale), raw_limits(signal)[1]
    if enumeration(signal) and enumeration(signal)[2]:
        return [f"    {raw} = ({raw_type(signal)}){value};"]
    if step == 1 and signal.length == integer_bits(signal):
        return [f"    {raw} = {value};"]
    if step == 1:
        return [f"    {fits} = {fits} && {value} <= {most}u;", f"    {raw} = {value};"]
    rounded = f"({value} + {step // 2}u) / {step}u"
    return [f"    {fits} = {fits} && {rounded} <= {most}u;", f"    {raw} = ({raw_type(signal)})({rounded});"]


def components(group: Group) -> str:
    return AXES if group.kind == "vector" else QUATERNION


def is_scaled(group: Group) -> bool:
    return scalar_type(group.first) == "float"


def pack_array(message: Message, group: Group) -> list[str]:
    return [
        line
        for i, signal in enumerate(group.signals)
        for line in pack_value(message, signal, f"message->{group.member}[{i}]", "fits")
    ]


def raw_array(group: Group) -> str:
    return group.member.split("_")[0]


def pack_scaled_arrays(message: Message, groups: list[Group]) -> list[str]:
    """Returns the statements that pack all scaled arrays in one loop over the joints. comanip_dev.codegen checks that
    the scales are equal."""
    if not groups:
        return []
    return [
        f"    int32_t {', '.join(f'{raw_array(group)}[{JOINTS}]' for group in groups)};",
        f"    for (int i = 0; i < {JOINTS}; i++) {{",
        *(
            f"        {raw_array(group)}[i] = "
            f"QUANTISE(fits, message->{group.member}[i], {constant(message, group.first)});"
            for group in groups
        ),
        "    }",
        *(
            f"    raw.{lower(s)} = {'' if raw_type(s) == 'int32_t' else f'({raw_type(s)})'}{raw_array(group)}[{i}];"
            for group in groups
            for i, s in enumerate(group.signals)
        ),
    ]


def pack_body(message: Message) -> list[str]:
    found = layout(message)
    lines = [f"    struct comanip_{snake(message)}_t raw;", "    bool fits = true;"]
    lines += [f"    raw.{lower(signal)} = 0; /* e2e.h writes it */" for signal in message.signals if is_header(signal)]
    flags = {group.validity.name: group.validity for group in found.groups if group.validity}
    for flag in flags:
        lines.append(f"    bool {flag}_fits = true;")
    scaled = [group for group in found.groups if group.kind == "array" and is_scaled(group)]
    lines += pack_scaled_arrays(message, scaled)
    for group in found.groups:
        if group.kind == "array":
            lines += [] if group in scaled else pack_array(message, group)
        elif group.kind == "scalar" and group.member not in flags:
            lines += pack_value(message, group.first, f"message->{group.member}", "fits")
        elif group.kind != "scalar":
            fits = f"{group.validity.name}_fits" if group.validity else "fits"
            for axis, signal in zip(components(group), group.signals, strict=True):
                lines += pack_value(message, signal, f"message->{found.access(group)}.{axis}", fits)
    for flag in flags:
        zeros = [lower(s) for g in found.groups if g.validity and g.validity.name == flag for s in g.signals]
        lines += [f"    if (!{flag}_fits) {{", *(f"        raw.{name} = 0;" for name in zeros), "    }"]
        lines += [f"    fits = fits && {flag}_fits;", f"    raw.{flag} = message->{flag} && {flag}_fits;"]
    return lines


def pack_function(message: Message) -> list[str]:
    kind = f"FRAME_{snake(message).upper()}"
    if family(message):
        kind = f"(frame_kind_t)({kind} + joint)"
    return [
        f"{signature_pack(message)} {{",
        *pack_body(message),
        f"    begin(frame, {kind});",
        f"    (void)comanip_{snake(message)}_pack(frame->data, &raw, sizeof frame->data);",
        "    return status_of(fits);",
        "}",
        "",
    ]


# ---- unpacking


def unpack_value(message: Message, signal: Signal, target: str) -> str:
    raw, kind = f"raw.{lower(signal)}", scalar_type(signal)
    if kind == "float" and not signal.is_float:
        return f"    {target} = UNPACK({constant(message, signal)}, {raw});"
    if kind == "bool":
        return f"    {target} = {raw} != 0u;"
    if enumeration(signal) and enumeration(signal)[2]:
        return f"    {target} = ({kind}){raw};"
    return (
        f"    {target} = {raw};" if int(signal.scale) == 1 else f"    {target} = {int(signal.scale)}u * ({kind}){raw};"
    )


def unpack_function(message: Message) -> list[str]:
    found = layout(message)
    lines = [
        f"{signature_unpack(message)} {{",
        f"    struct comanip_{snake(message)}_t raw;",
        f"    (void)comanip_{snake(message)}_unpack(&raw, frame->data, sizeof frame->data);",
    ]
    for group in found.groups:
        if group.kind == "scalar":
            lines.append(unpack_value(message, group.first, f"message->{group.member}"))
        elif group.kind == "array":
            lines += [unpack_value(message, s, f"message->{group.member}[{i}]") for i, s in enumerate(group.signals)]
        else:
            target = f"message->{found.access(group)}"
            lines += [
                unpack_value(message, s, f"{target}.{a}") for a, s in zip(components(group), group.signals, strict=True)
            ]
    return [*lines, "}", ""]


# ---- files


def signature_pack(message: Message) -> str:
    name = codec_name(message)
    joint = "int joint, " if family(message) else ""
    return f"protocol_status_t {name}_pack({joint}const {name}_t *message, can_frame_t *frame)"


def signature_unpack(message: Message) -> str:
    name = codec_name(message)
    return f"void {name}_unpack(const can_frame_t *frame, {name}_t *message)"


def with_codec(messages: list[Message]) -> list[Message]:
    """Returns the CAN FD messages, but only one of those that share a codec."""
    return [message for message in messages if not message.name.startswith(CLASSIC) and leads(message)]


def declaration(message: Message) -> list[str]:
    name = family(message) or message.name
    sender, receivers = message.senders[0], sorted(message.receivers)
    return [
        f"/* ---- {name}: {sender} -> {', '.join(receivers)} */",
        "",
        *(wrapped(message.comment) if message.comment else []),
        "typedef struct {",
        *members(layout(message)),
        f"}} {codec_name(message)}_t;",
        "",
        f"{signature_pack(message)};",
        f"{signature_unpack(message)};",
        "",
    ]


def header(messages: list[Message]) -> str:
    lines = [
        GENERATED,
        "/* Included by firmware/protocol/messages.h, which says how to use it. */",
        "#ifndef COMANIP_MESSAGES_H",
        "#define COMANIP_MESSAGES_H",
        "",
        *enumerations([message for message in messages if not message.name.startswith(CLASSIC)]),
        *(line for message in with_codec(messages) for line in declaration(message)),
        "#endif",
        "",
    ]
    return "\n".join(lines)


def bodies(messages: list[Message]) -> str:
    functions = (f for message in with_codec(messages) for f in (pack_function(message), unpack_function(message)))
    return "\n".join([GENERATED, "", *(line for function in functions for line in function)])
