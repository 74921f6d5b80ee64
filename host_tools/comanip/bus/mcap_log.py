"""Writes logs as MCAP for Foxglove and Lichtblick. Each message of the DBC has its own channel, encoded as JSON."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import BinaryIO

from cantools.database.can.message import Message

from comanip.bus.frame import Frame, decode, messages
from comanip.errors import ToolError

TOPIC = "/can/"
FOREIGN = "Foreign"
NS_PER_US = 1000


def signal_schema(signal) -> dict:
    description = f"{signal.unit}" if signal.unit else ""
    if signal.choices:
        return {"type": "string", "description": "one of " + ", ".join(str(name) for name in signal.choices.values())}
    whole = not signal.is_float and float(signal.scale).is_integer()
    return {"type": "integer" if whole else "number", "description": description}


def message_schema(message: Message) -> dict:
    return {
        "title": message.name,
        "type": "object",
        "description": message.comment or "",
        "properties": {signal.name: signal_schema(signal) for signal in message.signals},
    }


def foreign_schema() -> dict:
    """Returns the schema of frames that are not in the DBC."""
    return {
        "title": FOREIGN,
        "type": "object",
        "properties": {"id": {"type": "integer"}, "data": {"type": "string", "description": "hexadecimal"}},
    }


def signals_json(frame: Frame) -> dict:
    """Returns the signals by name. Each enumerated value is given as its name, or as a decimal string if the value
    has no name."""
    enumerated = {signal.name for signal in frame.message.signals if signal.choices}
    return {name: str(value) if name in enumerated else value for name, value in decode(frame).items()}


def write(file: BinaryIO, frames: Iterable[Frame]) -> int:
    """Writes the frames and returns their number."""
    try:
        from mcap.writer import Writer
    except ImportError as error:
        raise ToolError("MCAP needs the package mcap: pip install mcap") from error
    writer = Writer(file)
    writer.start(profile="", library="comanip")
    channels: dict[str, int] = {}
    count = 0
    for frame in frames:
        known = frame.message is not None and len(frame.data) >= frame.message.length
        name = frame.message.name if known else FOREIGN
        if name not in channels:
            schema = message_schema(messages()[frame.frame_id]) if known else foreign_schema()
            schema_id = writer.register_schema(f"comanip.{name}", "jsonschema", json.dumps(schema).encode())
            channels[name] = writer.register_channel(TOPIC + name, "json", schema_id)
        content = signals_json(frame) if known else {"id": frame.frame_id, "data": frame.data.hex()}
        time_ns = NS_PER_US * frame.t_us
        writer.add_message(channels[name], time_ns, json.dumps(content).encode(), time_ns, sequence=count)
        count += 1
    writer.finish()
    return count
