"""Determines which signals of the DBC form one member of a message's C struct.

The names of the signals determine the member:

``NAME_0_UNIT`` .. ``NAME_7_UNIT``     an array NAME_UNIT[8] with one element for each joint
``BASE_x_m``, ``_y_m``, ``_z_m``       a vector3_t BASE_m; for ``x_m y_m z_m`` it is position_m
``BASE_w``, ``_x``, ``_y``, ``_z``     a quaternion_t BASE; for ``qw qx qy qz`` it is rotation
``BASE_x_m`` .. and ``BASE_qw`` ..     a pose_t BASE
``valid`` or ``BASE_valid``            a flag that is true if the vector and the quaternion of BASE are valid

The attribute EnumType of a signal, "TYPE PREFIX", declares an enumeration for its value table. With "TYPE PREFIX
number" the enumeration is declared, but the member is an integer, because the signal may carry numbers that this
firmware does not know.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from cantools.database.can.c_source import camel_to_snake_case
from cantools.database.can.message import Message
from cantools.database.can.signal import Signal

CLASSIC = "Classic"  # prefix of the names of classic CAN frames
JOINTS = 8
AXES, QUATERNION = "xyz", "wxyz"
_JOINT = re.compile(r"_(\d)(?=_|$)")


def attribute(owner: Message | Signal, name: str, default=0):
    found = owner.dbc.attributes.get(name) if owner.dbc else None
    return found.value if found else default


def is_header(signal: Signal) -> bool:
    """Returns True for a signal of the end-to-end header."""
    return signal.name.startswith("e2e_")


def payload(message: Message) -> list[Signal]:
    """Returns the signals except those of the end-to-end header."""
    return [signal for signal in message.signals if not is_header(signal)]


def raw_limits(signal: Signal) -> tuple[int, int]:
    if signal.is_signed:
        return -(2 ** (signal.length - 1)), 2 ** (signal.length - 1) - 1
    return 0, 2**signal.length - 1


def integer_bits(signal: Signal, largest: int | None = None) -> int:
    """Returns the width of the smallest C integer that can hold the signal's raw value, or `largest` if given."""
    bits = signal.length if largest is None else largest.bit_length()
    return next(width for width in (8, 16, 32, 64) if width >= bits)


def raw_type(signal: Signal) -> str:
    """Returns the type of the signal in cantools' struct."""
    return f"{'int' if signal.is_signed else 'uint'}{integer_bits(signal)}_t"


@dataclass
class Group:
    """The signals of one member: a scalar, an array over the joints, a vector or a quaternion."""

    member: str
    kind: str  # "scalar", "array", "vector", "quaternion"
    signals: list[Signal]
    base: str = ""  # BASE of a vector or quaternion
    validity: Signal | None = None  # validity flag of a vector or quaternion

    @property
    def first(self) -> Signal:
        return self.signals[0]


@dataclass
class Layout:
    """The layout of a message, with its groups in the order of the signals."""

    message: Message
    groups: list[Group] = field(default_factory=list)

    @property
    def poses(self) -> set[str]:
        """The bases of poses: all bases, except the empty one, that have both a vector and a quaternion."""
        bases = {kind: {g.base for g in self.groups if g.kind == kind} for kind in ("vector", "quaternion")}
        return {base for base in bases["vector"] & bases["quaternion"] if base}

    def access(self, group: Group) -> str:
        """Returns the C expression for the member, such as `rotation`, or `target.rotation` in a pose."""
        if group.base not in self.poses:
            return group.member
        return f"{group.base}.{'translation_m' if group.kind == 'vector' else 'rotation'}"


def _vector_base(names: set[str], name: str) -> str | None:
    match = re.fullmatch(r"(?:(\w+)_)?x_m", name)
    base = match and (match[1] or "")
    prefix = f"{base}_" if base else ""
    return base if match and all(f"{prefix}{axis}_m" in names for axis in AXES) else None


def _quaternion_prefix(names: set[str], name: str) -> str | None:
    """Returns the prefix of a quaternion's signals, given the name of its w: `q` for qw, `target_q` for target_qw,
    `q_task_` for q_task_w. Returns None if the name is not that of a quaternion's w."""
    prefix = name[:-1]
    return prefix if name.endswith("w") and all(prefix + axis in names for axis in QUATERNION) else None


def layout(message: Message) -> Layout:
    """Returns the layout of a message. Raises SystemExit if an array does not have one element for each joint."""
    signals = {signal.name: signal for signal in payload(message)}
    found, taken = Layout(message), set()
    for name, signal in signals.items():
        if name in taken:
            continue
        base, prefix = _vector_base(set(signals), name), _quaternion_prefix(set(signals), name)
        if base is not None:
            members = [signals[f"{base}_{axis}_m" if base else f"{axis}_m"] for axis in AXES]
            group = Group(f"{base}_m" if base else "position_m", "vector", members, base)
        elif prefix is not None:
            base = prefix.removesuffix("q").removesuffix("_") if prefix.endswith("q") else prefix.removesuffix("_")
            member = base if not prefix.endswith("q") else f"{base}_rotation" if base else "rotation"
            group = Group(member, "quaternion", [signals[prefix + axis] for axis in QUATERNION], base)
        elif _JOINT.search(name):
            member = _JOINT.sub("", name)
            elements = [signals.get(_JOINT.sub(f"_{i}", name)) for i in range(JOINTS)]
            if None in elements:
                raise SystemExit(f"codegen: {message.name}.{name}: expected one signal for each of {JOINTS} joints")
            group = Group(member, "array", elements)
        else:
            group = Group(name, "scalar", [signal])
        if group.kind in ("vector", "quaternion"):
            group.validity = signals.get(f"{group.base}_valid" if group.base else "valid")
        taken |= {s.name for s in group.signals}
        found.groups.append(group)
    return found


def snake(message: Message) -> str:
    return camel_to_snake_case(message.name)


def constant(message: Message, signal: Signal) -> str:
    """Returns the common part of the names of the signal's constants in comanip_schema.h, without the prefix COMANIP_
    and without a suffix such as _PER_UNIT."""
    return f"{snake(message)}_{signal.name}".upper()


def lower(signal: Signal) -> str:
    """Returns the name of the signal in cantools' struct."""
    return camel_to_snake_case(signal.name)
