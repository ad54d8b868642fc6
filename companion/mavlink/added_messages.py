"""Defines messages that pymavlink lacks, or has without their newest fields.

They are those of the events service and of component metadata, and MISSION_CURRENT with the
numbers of the stored plans. Each row of `DEFINITIONS` repeats a message of common.xml: its number,
its name, its fields.
`define` turns it into a class like pymavlink's own, so that it is packed and decoded like them.

Source: common.xml, and https://mavlink.io/en/guide/serialization.html (order of the fields on the
wire, CRC_EXTRA).
"""

from __future__ import annotations

import struct
from types import ModuleType
from typing import Any, NamedTuple

Dialect = Any
"""pymavlink's module of a dialect."""

_CODES = {"uint8_t": "B", "uint16_t": "H", "uint32_t": "I", "char": "s"}


class MessageField(NamedTuple):
    """A field of a message; its length is 0 unless it is an array."""

    type: str
    name: str
    length: int = 0

    @property
    def size(self) -> int:
        """Bytes of one element."""
        return struct.calcsize(_CODES[self.type])

    @property
    def layout(self) -> str:
        """The field in the notation of `struct`."""
        return f"{self.length or ''}{_CODES[self.type]}"


class Definition(NamedTuple):
    """A message of common.xml, with its fields in the order given there.

    Extensions may be missing at the end of a frame; they are then 0.
    """

    number: int
    name: str
    fields: tuple[MessageField, ...]
    extensions: tuple[MessageField, ...] = ()

    @property
    def on_the_wire(self) -> list[MessageField]:
        """The fields in the order of the wire: largest types first, then the extensions."""
        return [*self.without_extensions, *self.extensions]

    @property
    def without_extensions(self) -> list[MessageField]:
        """The same for the fields that each frame has."""
        return sorted(self.fields, key=lambda field: -field.size)


_TARGET = (MessageField("uint8_t", "target_system"), MessageField("uint8_t", "target_component"))

DEFINITIONS = (
    Definition(
        42,
        "MISSION_CURRENT",
        (MessageField("uint16_t", "seq"),),
        (
            MessageField("uint16_t", "total"),
            MessageField("uint8_t", "mission_state"),
            MessageField("uint8_t", "mission_mode"),
            MessageField("uint32_t", "mission_id"),
            MessageField("uint32_t", "fence_id"),
            MessageField("uint32_t", "rally_points_id"),
        ),
    ),
    Definition(
        397,
        "COMPONENT_METADATA",
        (
            MessageField("uint32_t", "time_boot_ms"),
            MessageField("uint32_t", "file_crc"),
            MessageField("char", "uri", 100),
        ),
    ),
    Definition(
        410,
        "EVENT",
        (
            MessageField("uint8_t", "destination_component"),
            MessageField("uint8_t", "destination_system"),
            MessageField("uint32_t", "id"),
            MessageField("uint32_t", "event_time_boot_ms"),
            MessageField("uint16_t", "sequence"),
            MessageField("uint8_t", "log_levels"),
            MessageField("uint8_t", "arguments", 40),
        ),
    ),
    Definition(
        411,
        "CURRENT_EVENT_SEQUENCE",
        (MessageField("uint16_t", "sequence"), MessageField("uint8_t", "flags")),
    ),
    Definition(
        412,
        "REQUEST_EVENT",
        (
            *_TARGET,
            MessageField("uint16_t", "first_sequence"),
            MessageField("uint16_t", "last_sequence"),
        ),
    ),
    Definition(
        413,
        "RESPONSE_EVENT_ERROR",
        (
            *_TARGET,
            MessageField("uint16_t", "sequence"),
            MessageField("uint16_t", "sequence_oldest_available"),
            MessageField("uint8_t", "reason"),
        ),
    ),
)


def extended(common: Dialect) -> Dialect:
    """Returns a copy of a dialect that has these messages, under names like its own.

    The dialect itself stays as it is: others in the process may use it.
    """
    dialect: Any = ModuleType(__name__)
    vars(dialect).update(vars(common), mavlink_map=dict(common.mavlink_map))
    for definition in DEFINITIONS:
        kind = define(dialect, definition)
        dialect.mavlink_map[definition.number] = kind
        setattr(dialect, kind.__name__, kind)
        setattr(dialect, f"MAVLINK_MSG_ID_{definition.name}", definition.number)
    return dialect


def define(dialect: Dialect, definition: Definition) -> Any:
    """Returns the class of a message, with the attributes of pymavlink's own classes."""
    fields, wire = definition.fields + definition.extensions, definition.on_the_wire
    names = [field.name for field in fields]
    defaults = {field.name: 0 for field in definition.extensions}
    layout = struct.Struct("<" + "".join(field.layout for field in wire))

    def __init__(self: Any, *values: Any, **named: Any) -> None:
        dialect.MAVLink_message.__init__(self, definition.number, definition.name)
        self._fieldnames, self._instance_field, self._instance_offset = names, None, -1
        given = defaults | dict(zip(names, values, strict=False)) | named
        for name in names:
            value = given.pop(name)
            if isinstance(value, bytes):
                setattr(self, f"_{name}_raw", value)
                value = value.partition(b"\0")[0].decode(errors="replace")
            setattr(self, name, value)
        if given:
            raise TypeError(f"{definition.name} has no {', '.join(given)}")

    def pack(self: Any, mav: Any, force_mavlink1: bool = False) -> Any:
        values: list[Any] = []
        for field in wire:
            value = getattr(self, f"_{field.name}_raw", getattr(self, field.name))
            values += value if isinstance(value, list) else [value]
        return self._pack(mav, kind.crc_extra, layout.pack(*values), force_mavlink1=force_mavlink1)

    kind: Any = type(
        f"MAVLink_{definition.name.lower()}_message",
        (dialect.MAVLink_message,),
        {
            "__init__": __init__,
            "pack": pack,
            "id": definition.number,
            "msgname": definition.name,
            "fieldnames": names,
            "ordered_fieldnames": [field.name for field in wire],
            "fieldtypes": [field.type for field in fields],
            "fielddisplays_by_name": {},
            "fieldenums_by_name": {},
            "fieldunits_by_name": {},
            "native_format": bytearray(layout.format.encode()),
            "orders": [wire.index(field) for field in fields],
            "lengths": [1 if field.type == "char" else field.length or 1 for field in wire],
            "array_lengths": [field.length for field in wire],
            "crc_extra": crc_extra(dialect, definition),
            "unpacker": layout,
            "instance_field": None,
            "instance_offset": -1,
        },
    )
    return kind


def crc_extra(dialect: Dialect, definition: Definition) -> int:
    """Returns the byte by which both ends check that they mean the same message."""
    text = f"{definition.name} ".encode()
    for field in definition.without_extensions:
        text += f"{field.type} {field.name} ".encode()
        if field.length:
            text += bytes([field.length])
    crc: int = dialect.mcrf4xx(text, 0xFFFF)
    return (crc & 0xFF) ^ (crc >> 8)
