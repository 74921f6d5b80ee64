"""Reads and checks the description of the firmware's parameters, ``schema/parameters.toml``.

Errors are raised as ToolError, which names the file and the entry and states what was found and what was expected.
"""

from __future__ import annotations

import functools
import math
import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from comanip.errors import ToolError

PATH = Path(__file__).with_name("schema") / "parameters.toml"
NUMBERS = 64  # width of the bit masks in which the firmware stores sets of parameters
NAME_MAX_CHARACTERS = 40
KINDS = ("float", "integer", "boolean")
_REQUIRED = ("number", "name", "unit", "range", "default", "group", "meaning")
_OPTIONAL = ("components", "type")
_PI = re.compile(r"(-?)pi(?:/(\d+))?")


@dataclass(frozen=True)
class Parameter:
    """A parameter. minimum, maximum, default: in `unit`. kind: one of KINDS. vector: for a component of a vector, the
    name of the vector; otherwise the same as `name`."""

    number: int
    name: str
    unit: str
    kind: str
    minimum: float
    maximum: float
    default: float
    group: str
    meaning: str
    vector: str


def _refusal(path: Path, entry: dict, problem: str) -> ToolError:
    name = entry.get("name", f"number {entry.get('number', '?')}")
    return ToolError(f"{path}: parameter '{name}': {problem}")


def _value(path: Path, entry: dict, key: str, value: object) -> float:
    match = _PI.fullmatch(value) if isinstance(value, str) else None
    if match:
        return (-1.0 if match[1] else 1.0) * math.pi / int(match[2] or 1)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise _refusal(path, entry, f"{key} {value!r}: expected a number, or a fraction of pi such as '-pi/2'")
    return float(value)


def _check_keys(path: Path, entry: dict) -> None:
    for key in entry:
        if key not in (*_REQUIRED, *_OPTIONAL):
            raise _refusal(path, entry, f"unknown key '{key}': expected {', '.join((*_REQUIRED, *_OPTIONAL))}")
    for key in _REQUIRED:
        if key not in entry:
            raise _refusal(path, entry, f"no {key}: expected {', '.join(_REQUIRED)}; add it, as in the other entries")
    for key in ("name", "unit", "group", "meaning"):
        if not isinstance(entry[key], str) or not entry[key].isascii() or '"' in entry[key] or "\\" in entry[key]:
            raise _refusal(path, entry, f"{key} {entry[key]!r}: expected ASCII text without quotes or backslashes")
    if entry.get("type", "float") not in KINDS:
        raise _refusal(path, entry, f"type {entry['type']!r}: expected one of {', '.join(KINDS)}")
    if not isinstance(entry["number"], int) or not 0 <= entry["number"] < NUMBERS:
        raise _refusal(path, entry, f"number {entry['number']!r}: expected 0 to {NUMBERS - 1}")


def _names(path: Path, entry: dict) -> list[str]:
    components = entry.get("components", [])
    if ("*" in entry["name"]) != bool(components):
        raise _refusal(path, entry, "expected a * in the name if the entry has components, and no * otherwise")
    names = [entry["name"].replace("*", component) for component in components] or [entry["name"]]
    for name in names:
        if not re.fullmatch(r"[a-z][a-z0-9_]*", name) or len(name) > NAME_MAX_CHARACTERS:
            raise _refusal(
                path, entry, f"name '{name}': expected a-z, 0-9, _; at most {NAME_MAX_CHARACTERS} characters"
            )
    return names


def _expanded(path: Path, entry: dict) -> Iterator[Parameter]:
    """Yields the parameters of an entry: one for each component of a vector, otherwise a single parameter."""
    _check_keys(path, entry)
    names, kind = _names(path, entry), entry.get("type", "float")
    if not isinstance(entry["range"], list) or len(entry["range"]) != 2:
        raise _refusal(path, entry, f"range {entry['range']!r}: expected [least, greatest]")
    low, high = (_value(path, entry, "range", bound) for bound in entry["range"])
    if not low < high or (kind == "boolean" and (low, high) != (0.0, 1.0)):
        raise _refusal(path, entry, f"range {entry['range']!r}: expected least < greatest, and [0, 1] for a boolean")
    defaults = entry["default"] if isinstance(entry["default"], list) else [entry["default"]] * len(names)
    if len(defaults) != len(names):
        raise _refusal(
            path, entry, f"{len(defaults)} defaults, expected one, or one for each of {len(names)} components"
        )
    for i, (name, default) in enumerate(zip(names, defaults, strict=True)):
        value = _value(path, entry, "default", default)
        if not low <= value <= high or (kind != "float" and value != round(value)):
            raise _refusal(
                path, entry, f"default {default!r}: expected a value of type {kind} within {entry['range']!r}"
            )
        vector = entry["name"].replace("_*", "").replace("*_", "")
        number = entry["number"] + i
        yield Parameter(number, name, entry["unit"], kind, low, high, value, entry["group"], entry["meaning"], vector)


def read(path: Path = PATH) -> list[Parameter]:
    """Returns all parameters, sorted by number."""
    try:
        document = tomllib.loads(path.read_text())
    except (OSError, tomllib.TOMLDecodeError) as error:
        raise ToolError(f"{path}: {error}") from error
    found: dict[int, Parameter] = {}
    for entry in document.get("parameter", []):
        for parameter in _expanded(path, entry):
            other = found.get(parameter.number)
            if other:
                raise _refusal(
                    path,
                    entry,
                    f"number {parameter.number} is already used by '{other.name}', expected an unused number",
                )
            if parameter.number in document.get("retired", []) or parameter.number >= NUMBERS:
                raise _refusal(
                    path, entry, f"number {parameter.number} is retired or above {NUMBERS - 1}, expected a free one"
                )
            if parameter.name in {p.name for p in found.values()}:
                raise _refusal(path, entry, f"the name '{parameter.name}' is used twice, expected once")
            found[parameter.number] = parameter
    if not found:
        raise ToolError(f"{path}: no [[parameter]], expected at least one")
    return [found[number] for number in sorted(found)]


@functools.cache
def all_parameters() -> dict[str, Parameter]:
    """Returns all parameters by name, sorted by number."""
    return {parameter.name: parameter for parameter in read()}
