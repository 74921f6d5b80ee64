"""Checks that every frame and parameter has a reader: ``python -m comanip_dev.schema.readers`` (``make check``).

For frames that the firmware receives, the compiler does this check, because each frame must have a function in
firmware/controller_inputs.c. A frame for another node counts as read if sim/ calls its X_unpack(), or if a tool in
host_tools/comanip mentions the name of the message or of its frame kind. A parameter counts as read if firmware/ uses
its enumerator.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import cantools
from cantools.database.can.message import Message
from comanip import parameters
from comanip.parameters import Parameter

from comanip_dev import REPOSITORY
from comanip_dev.schema.messages import codec_name, family, with_codec
from comanip_dev.schema.signals import snake


def _text(folder: Path, *suffixes: str) -> str:
    return "\n".join(file.read_text() for file in sorted(folder.rglob("*")) if file.suffix in suffixes)


def without_reader(messages: Sequence[Message], simulator: str, tools: str) -> Iterable[str]:
    """Yields the names of messages without a reader. simulator, tools: text of the sources of simulator and tools."""
    for message in with_codec(messages):
        name = family(message) or message.name
        kind = f"FRAME_{snake(message).upper()}"
        is_read = f"{codec_name(message)}_unpack(" in simulator or f'"{name}' in tools or kind in tools
        if set(message.receivers) != {"Firmware"} and not is_read:
            yield message.name


def unused(parameters: Iterable[Parameter], firmware: str) -> list[str]:
    """Returns the names of the parameters and vectors of parameters that the firmware does not use. firmware: text of
    the firmware's sources."""
    vectors = dict.fromkeys(parameter.vector for parameter in parameters)
    return [vector for vector in vectors if not re.search(rf"\bPARAMETER_{vector.upper()}\b", firmware)]


def main() -> int:
    database = cantools.database.load_file(REPOSITORY / "firmware" / "schema" / "comanip.dbc")
    simulator = _text(REPOSITORY / "sim", ".c")
    tools = _text(REPOSITORY / "host_tools" / "comanip", ".py", ".c")
    found = list(without_reader(database.messages, simulator, tools))
    for name in found:
        print(
            f"check: {name}: no reader, expected a call of its unpack function in sim/ "
            "or its name in host_tools/comanip",
            file=sys.stderr,
        )
    ignored = unused(parameters.read(), _text(REPOSITORY / "firmware", ".c", ".h"))
    for name in ignored:
        print(f"check: {name}: no reader, expected PARAMETER_{name.upper()} in firmware/", file=sys.stderr)
    return 1 if found or ignored else 0


if __name__ == "__main__":
    sys.exit(main())
