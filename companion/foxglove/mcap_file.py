"""Writes messages of Foxglove as an MCAP file.

It is written after the flight, never during it: a message takes 0.2 ms, and few programs read a
file without its end. Messages are JSON, with a JSON Schema for each topic; chunks are compressed
with zstd.

Source: https://mcap.dev/spec; the library writes the records.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import IO, Any

from mcap.writer import CompressionType, Writer

from companion.foxglove.messages import NANO, LogMessage, stamp
from companion.foxglove.schemas import SCHEMAS

LIBRARY = "mav-companion"


def write_mcap(
    stream: IO[bytes],
    start_unix_ns: int,
    messages: Iterable[LogMessage],
    attachments: Mapping[str, bytes],
) -> int:
    """Writes a file.

    Args:
        stream: to write to.
        start_unix_ns: when the run began.
        messages: in order.
        attachments: attached files, by name.

    Returns:
        The number of messages.
    """
    writer = Writer(stream, compression=CompressionType.ZSTD)
    writer.start(library=LIBRARY)
    schemas: dict[str, int] = {}
    channels: dict[str, int] = {}
    for name, data in attachments.items():
        kind = "application/json" if name.endswith(".json") else "text/plain"
        writer.add_attachment(start_unix_ns, start_unix_ns, name, kind, data)
    count = 0
    for count, message in enumerate(messages, 1):
        if message.topic not in channels:
            schema = schemas.get(message.schema)
            if schema is None:
                text = json.dumps(SCHEMAS[message.schema]).encode()
                schema = schemas[message.schema] = writer.register_schema(
                    message.schema, "jsonschema", text
                )
            channels[message.topic] = writer.register_channel(message.topic, "json", schema)
        unix_ns = start_unix_ns + round(message.time_s * NANO)
        data = json.dumps(_stamped(message, unix_ns), separators=(",", ":")).encode()
        writer.add_message(channels[message.topic], unix_ns, data, unix_ns, count)
    writer.finish()  # type: ignore[no-untyped-call]
    return count


def _stamped(message: LogMessage, unix_ns: int) -> dict[str, Any]:
    """The content of a message, with its time if its schema has one."""
    time = stamp(unix_ns)
    match message.schema:
        case "foxglove.GeoJSON":
            return message.content
        case "foxglove.SceneUpdate":
            entities = [{"timestamp": time, **each} for each in message.content["entities"]]
            return {"deletions": message.content["deletions"], "entities": entities}
    return {"timestamp": time, **message.content}
