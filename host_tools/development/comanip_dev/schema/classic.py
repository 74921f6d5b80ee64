"""Generates the functions that split the CAN FD frame of a message into classic CAN frames and join them again.

The functions work on raw integers as described by the DBC. ``comanip_classic.inc``, which is included by
firmware/protocol/can_classic.c, contains split_X() and join_X() for each message and a table of these functions. The
parts of a message are the Classic* messages whose attribute PartOf names the message, in the order of the DBC. The name
and scale of a signal in a part determine what the signal carries:

- the name of a signal of the message, with the same scale or a scale coarser by an integer factor: the value of that
  signal, rounded; a value out of range does not fit;
- ``BASE_a``, ``_b``, ``_c``, ``_largest``: the message's quaternion BASE in smallest-three code (rotation_code.h);
- ``NAME_low`` and ``NAME_high``: the low and high bits of the message's NAME or NAME_us; higher bits are dropped.

A signal that no part carries is 0 after joining. If a vector or quaternion with a validity flag does not fit into the
parts, its values and the flag are sent as 0. If any other value does not fit, split_X() returns false.
"""

from __future__ import annotations

import re

from cantools.database.can.message import Message
from cantools.database.can.signal import Signal

from comanip_dev.schema.messages import GENERATED, codec_name, family
from comanip_dev.schema.signals import (
    CLASSIC,
    JOINTS,
    QUATERNION,
    attribute,
    integer_bits,
    layout,
    lower,
    payload,
    raw_limits,
    raw_type,
    snake,
)

_CODE = re.compile(r"(\w+)_(a|b|c|largest)")
_HALF = re.compile(r"(\w+)_(low|high)")


def parts_of(messages: list[Message]) -> dict[str, list[Message]]:
    """Returns the parts of each message, by the name of the message. Raises SystemExit if a Classic* message is not a
    part of any message."""
    names = {message.name for message in messages if not message.name.startswith(CLASSIC)}
    found: dict[str, list[Message]] = {}
    for message in messages:
        if not message.name.startswith(CLASSIC):
            continue
        whole = str(attribute(message, "PartOf", ""))
        if whole not in names:
            raise SystemExit(f"codegen: {message.name}: PartOf '{whole}': expected the name of a message for CAN FD")
        found.setdefault(whole, []).append(message)
    return found


def _ratio(whole: Signal, part: Signal) -> int:
    ratio = float(part.scale) / float(whole.scale)
    if abs(ratio - round(ratio)) > 1e-6 * ratio or round(ratio) < 1:
        raise SystemExit(
            f"codegen: {part.name}: scale {part.scale} on classic CAN, expected a multiple of {whole.scale}"
        )
    return round(ratio)


class Codec:
    """Generates split_X() and join_X() of one message."""

    def __init__(self, message: Message, parts: list[Message]):
        self.message, self.parts = message, parts
        self.layout = layout(message)
        self.signals = {signal.name: signal for signal in payload(message)}
        self.flags = {g.validity.name for g in self.layout.groups if g.validity}
        self.flag_of = {s.name: g.validity.name for g in self.layout.groups if g.validity for s in g.signals}
        self.split: list[str] = []
        self.join: list[str] = []

    # ---- one signal of a part

    def _fits(self, name: str) -> str:
        return f"{self.flag_of[name]}_fits" if name in self.flag_of else "fits"

    def _copy(self, place: int, part: Signal, whole: Signal) -> None:
        raw, to, fits = f"from.{lower(whole)}", f"part_{place}.{lower(part)}", self._fits(whole.name)
        ratio = 1 if part.is_float else _ratio(whole, part)
        low, high = raw_limits(part)
        if whole.name in self.flags:
            self.split.append(f"    {to} = {whole.name}_fits;")
        elif ratio > 1:
            self.split.append(f"    {fits} = coarsen({raw}, {ratio}, {high}, &coarse) && {fits};")
            self.split.append(f"    {to} = ({raw_type(part)})coarse;")
        elif part.length < whole.length and not part.is_float:
            if part.is_signed:
                raise SystemExit(f"codegen: {part.name}: fewer bits and the same scale, expected an unsigned signal")
            self.split.append(f"    {fits} = {raw} <= {high}u && {fits};")
            self.split.append(f"    {to} = ({raw_type(part)}){raw};")
        else:
            self.split.append(f"    {to} = {raw};")
        value = f"joined_{place}.{lower(part)}"
        if ratio > 1:
            narrow = integer_bits(whole) < 32
            value = f"({raw_type(whole)})({ratio} * {value})" if narrow else f"{ratio} * {value}"
        self.join.append(f"    to.{lower(whole)} = {value};")

    def _rotation(self, place: int, base: str) -> None:
        prefix = next((p for p in (base, f"{base}_", f"{base}_q") if f"{p}w" in self.signals), None)
        if prefix is None:
            raise SystemExit(f"codegen: {base}_a: the message {self.message.name} has no quaternion {base}")
        names = [lower(self.signals[prefix + axis]) for axis in QUATERNION]
        fits, code = self._fits(prefix + "w"), f"code_{place}"
        bits = round(1 / float(self.signals[prefix + "w"].scale)).bit_length() - 1
        step = f"ROTATION_STEP({bits})"
        values = ", ".join(f"from.{name} * {step}" for name in names)
        self.split += [
            f"    rotation_code_t {code} = {{0}};",
            f"    {fits} = {fits} && rotation_encode((const int32_t[4]){{{values}}}, &{code});"
            if fits != "fits"
            else f"    fits = rotation_encode((const int32_t[4]){{{values}}}, &{code}) && fits;",
        ]
        members = [(f"{base}_{letter}".lower(), f"smaller[{i}]") for i, letter in enumerate("abc")]
        members.append((f"{base}_largest".lower(), "largest"))
        self.split += [f"    part_{place}.{name} = {code}.{member};" for name, member in members]
        smaller = ", ".join(f"joined_{place}.{name}" for name, _ in members[:3])
        self.join += [
            f"    const rotation_code_t {code} = {{.smaller = {{{smaller}}}, "
            f".largest = joined_{place}.{members[3][0]}}};",
            f"    int32_t rotation_{place}[4];",
            f"    rotation_decode(&{code}, rotation_{place});",
        ]
        for i, name in enumerate(names):
            kind = raw_type(self.signals[prefix + QUATERNION[i]])
            rounded = f"divide_rounding(rotation_{place}[{i}], {step})"
            self.join.append(f"    to.{name} = {rounded if kind == 'int32_t' else f'({kind}){rounded}'};")

    def _half(self, place: int, part: Signal, base: str) -> None:
        whole = self.signals.get(base) or self.signals.get(f"{base}_us")
        if whole is None:
            raise SystemExit(f"codegen: {part.name}: the message {self.message.name} has no {base} or {base}_us")
        low = next(s for p in self.parts for s in p.signals if s.name == f"{base}_low")
        shift = low.length if part.name.endswith("_high") and part.scale == low.scale else 0
        step = _ratio(whole, part) << shift
        raw, wide = f"from.{lower(whole)}", raw_type(whole)
        mask = raw_limits(part)[1]
        suffix = "ull" if wide == "uint64_t" else "u"
        self.split.append(
            f"    part_{place}.{lower(part)} = ({raw_type(part)})({raw} / {step}{suffix} & {mask}{suffix});"
        )
        operator = "=" if part.name.endswith("_low") else "+="
        self.join.append(f"    to.{lower(whole)} {operator} {step}{suffix} * ({wide})joined_{place}.{lower(part)};")

    # ---- functions

    def _part(self, place: int, part: Message) -> None:
        for signal in payload(part):
            code, half = _CODE.fullmatch(signal.name), _HALF.fullmatch(signal.name)
            if signal.name in self.signals:
                self._copy(place, signal, self.signals[signal.name])
            elif code:
                if code[2] == "a":
                    self._rotation(place, code[1])
            elif half:
                self._half(place, signal, half[1])
            else:
                raise SystemExit(
                    f"codegen: {part.name}.{signal.name}: the message {self.message.name} has no such signal"
                )

    def functions(self) -> list[str]:
        name, count = codec_name(self.message), len(self.parts)
        for place, part in enumerate(self.parts):
            self._part(place, part)
        needs_coarse = any("coarsen(" in line for line in self.split)
        structs = [f"struct comanip_{snake(part)}_t" for part in self.parts]
        names = [snake(part).removeprefix("classic_") for part in self.parts]
        # Flags are written last, because they also depend on values that come after them in the message.
        late = [
            line
            for line in self.split
            if re.search(r"= \w+_fits;$", line) and line.split(".")[-1].split(" ")[0] in self.flags
        ]
        early = [line for line in self.split if line not in late]
        zeros = []
        for flag in sorted(self.flags):
            members = [m.split(" = ")[0].strip() for m in early if self._governed(m, flag)]
            zeros += [f"    if (!{flag}_fits) {{", *(f"        {member} = 0;" for member in members), "    }"]
        return [
            f"static bool split_{name}(const message_t message, part_t part[]) {{",
            f"    FROM_MESSAGE({snake(self.message)}, from);",
            *(f"    {struct} part_{i} = {{0}};" for i, struct in enumerate(structs)),
            "    bool fits = true;",
            *(f"    bool {flag}_fits = from.{flag} != 0u;" for flag in sorted(self.flags)),
            *(["    int32_t coarse;"] if needs_coarse else []),
            *early, *zeros, *late,
            *(f"    TO_PART({part}, part_{i}, {i});" for i, part in enumerate(names)),
            "    return fits;",
            "}",
            "",
            f"static void join_{name}(part_t part[], message_t message) {{",
            f"    struct comanip_{snake(self.message)}_t to = {{0}};",
            *(f"    FROM_PART({part}, joined_{i}, {i});" for i, part in enumerate(names)),
            *self.join,
            f"    TO_MESSAGE({snake(self.message)}, to);",
            "}",
            "",
        ] if count else []  # fmt: skip

    def _governed(self, line: str, flag: str) -> bool:
        """Returns True if the line writes a component of the vector or quaternion to which this flag belongs."""
        match = re.match(r"    part_(\d+)\.(\w+) = ", line)
        if not match:
            return False
        code = _CODE.fullmatch(match[2])
        bases = {g.base for g in self.layout.groups if g.validity and g.validity.name == flag}
        if code:
            return code[1] in bases or (code[1] == "q" and "" in bases)
        return any(lower(self.signals[n]) == match[2] for n, f in self.flag_of.items() if f == flag)


class JointCodec(Codec):
    """Generates the functions of a message that consists only of arrays. Part i carries the values of joint i."""

    def functions(self) -> list[str]:
        name, part = codec_name(self.message), self.parts[0]
        arrays = [(group, next(s for s in payload(part) if s.name == group.member)) for group in self.layout.groups]
        parameters, body, joined = [], [], []
        for group, signal in arrays:
            whole, raw = group.first, lower(signal)
            ratio = _ratio(whole, signal)
            parameters.append(f"{raw_type(whole)} {raw}")
            if ratio > 1:
                body.append(f"    fits = coarsen({raw}, {ratio}, {raw_limits(signal)[1]}, &coarse) && fits;")
                body.append(f"    to.{raw} = ({raw_type(signal)})coarse;")
                joined.append((group, f"({raw_type(whole)})({ratio} * from.{raw})"))
            else:
                body.append(f"    to.{raw} = {raw};")
                joined.append((group, f"from.{raw}"))
        own = snake(part).removeprefix("classic_")
        lines = [
            f"static bool split_{name}_part({', '.join(parameters)}, part_t part) {{",
            f"    struct comanip_classic_{own}_t to = {{0}};",
            "    int32_t coarse;",
            "    bool fits = true;",
            *body,
            f"    (void)comanip_classic_{own}_pack(part, &to, sizeof(part_t));",
            "    return fits;",
            "}",
            "",
            f"static bool split_{name}(const message_t message, part_t part[]) {{",
            f"    FROM_MESSAGE({snake(self.message)}, from);",
            "    bool fits = true;",
        ]
        for i in range(JOINTS):
            arguments = ", ".join(f"from.{lower(group.signals[i])}" for group, _ in arrays)
            lines.append(f"    fits = split_{name}_part({arguments}, part[{i}]) && fits;")
        lines += ["    return fits;", "}", ""]
        lines += [
            f"static void join_{name}(part_t part[], message_t message) {{",
            f"    struct comanip_{snake(self.message)}_t to = {{0}};",
        ]
        for i in range(JOINTS):
            lines += ["    {", f"        FROM_PART({own}, from, {i});"]
            lines += [f"        to.{lower(group.signals[i])} = {value};" for group, value in joined]
            lines.append("    }")
        return [*lines, f"    TO_MESSAGE({snake(self.message)}, to);", "}", ""]


def codec_of(message: Message, parts: list[Message]) -> Codec:
    is_by_joint = len(parts) == JOINTS and all(group.kind == "array" for group in layout(message).groups)
    return (JointCodec if is_by_joint else Codec)(message, parts)


def bodies(messages: list[Message]) -> str:
    lines, rows = [GENERATED, ""], []
    parts = parts_of(messages)
    for message in messages:
        if message.name not in parts:
            continue
        own = parts[message.name]
        if family(message) is None or message.name.endswith("0"):
            lines += codec_of(message, own).functions()
        first, name = snake(own[0]).removeprefix("classic_").upper(), codec_name(message)
        rows.append(
            f"    [FRAME_{snake(message).upper()}] = {{CLASSIC_{first}, {len(own)}, split_{name}, join_{name}}},"
        )
    table = ["static const codec_t codec_table[FRAME_KIND_COUNT] = {", *rows, "};", ""]
    return "\n".join([*lines, *table])
