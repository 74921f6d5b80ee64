"""Does every frame have somebody who reads it? ``python -m comanip_dev.schema.readers`` (``make check``).

The firmware's frames have a function each, or do not compile (firmware/controller_inputs.c). A frame for another node is
read where its X_unpack() is called in sim/, or where a tool in host_tools/comanip names the message, or its kind.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import cantools
from cantools.database.can.message import Message

from comanip_dev import REPOSITORY
from comanip_dev.schema.messages import codec_name, family, with_codec
from comanip_dev.schema.signals import snake


def _text(folder: Path, *suffixes: str) -> str:
    return "\n".join(file.read_text() for file in sorted(folder.rglob("*")) if file.suffix in suffixes)


def without_reader(messages: Sequence[Message], simulator: str, tools: str) -> Iterable[str]:
    """Names of messages that nobody reads. simulator, tools: the text of their sources."""
    for message in with_codec(messages):
        name = family(message) or message.name
        kind = f"FRAME_{snake(message).upper()}"
        is_read = f"{codec_name(message)}_unpack(" in simulator or f'"{name}' in tools or kind in tools
        if set(message.receivers) != {"Firmware"} and not is_read:
            yield message.name


def main() -> int:
    database = cantools.database.load_file(REPOSITORY / "firmware" / "schema" / "comanip.dbc")
    simulator = _text(REPOSITORY / "sim", ".c")
    tools = _text(REPOSITORY / "host_tools" / "comanip", ".py", ".c")
    found = list(without_reader(database.messages, simulator, tools))
    for name in found:
        print(
            f"check: {name}: nobody reads it, expected {name}_unpack() in sim/ or its name in host_tools/comanip",
            file=sys.stderr,
        )
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
