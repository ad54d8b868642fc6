"""Turns a component's events into words, by the metadata file that the component holds.

The input is that file (JSON, plain or xz); the output is a definition for each event number. The
file comes from others: malformed parts are left out, too large ones are refused, and only
`MetadataError` is raised.

A message is a template: `{2:.1m}` is the second argument with one decimal place and a unit, `\\<`
is a literal character, `<param>`, `<a>` and `<profile>` are tags. Text for developers is left out,
and so are unknown tags with their content. Descriptions and translations are not used.

Source: https://mavlink.io/en/services/events.html, and the description of libevents.
"""

from __future__ import annotations

import json
import lzma
import re
import struct
from dataclasses import dataclass
from typing import Any

from companion.errors import printable

MOST_FILE_BYTES = 256 * 1024
"""Of the file as it is sent; PX4 v1.16's has 16 KiB."""
MOST_BYTES = 1024 * 1024
"""Of the JSON; PX4 v1.16's has 160 KiB."""
MOST_MEMORY = 96 * 1024 * 1024
"""For unpacking: xz requests 65 MiB at its best level, but uses only what it unpacks."""
MOST_ARGUMENTS = 40
"""Bytes of the arguments in an EVENT."""
MOST_TEMPLATE = 500
MOST_TEXT = 200
_XZ = b"\xfd7zXZ\0"
_EVENTS = 4  # COMP_METADATA_TYPE_EVENTS

_CODES = {
    "uint8_t": "B",
    "int8_t": "b",
    "uint16_t": "H",
    "int16_t": "h",
    "uint32_t": "I",
    "int32_t": "i",
    "uint64_t": "Q",
    "int64_t": "q",
    "float": "f",
}
_UNITS = {"m_v": "m"}  # vertical metres
_TOKEN = re.compile(
    r"""\\(?P<escaped>.)
    |\{(?P<argument>\d{1,2})(?::(?:\.(?P<digits>\d))?)?(?P<unit>[^{}]{0,8})\}
    |<(?P<tag>[a-z]{1,16})(?:\ +name="(?P<profile>[^"]*)"|\ [^<>]*)?>(?P<content>.*?)</(?P=tag)>""",
    re.VERBOSE | re.DOTALL,
)

Arguments = tuple[int | float, ...]


class MetadataError(Exception):
    """A metadata file cannot be used; the text says why."""


@dataclass(frozen=True, slots=True)
class Choices:
    """An enum of the metadata.

    Attributes:
        separator: put between the bits that are set; None if the value is not a set of bits.
        words: by value.
    """

    separator: str | None
    words: dict[int, str]

    def in_words(self, value: int) -> str:
        """The words for a value; a value without a word is given as a number."""
        if self.separator is None:
            return self._word(value)
        bits = [1 << bit for bit in range(64) if value >> bit & 1]
        return self.separator.join(map(self._word, bits))

    def _word(self, value: int) -> str:
        return self.words.get(value, f"(unknown: {value})")


@dataclass(frozen=True, slots=True)
class EventDefinition:
    """The metadata of an event.

    Attributes:
        name: the component's name for it.
        group: "default", "arming_check", "health", "calibration" or another one.
        type: "" for most; "summary" begins and ends a report.
        template: of its message.
        layout: of its arguments, in the notation of `struct`.
        choices: of each argument; None for a number.
    """

    name: str
    group: str
    type: str
    template: str
    layout: str
    choices: tuple[Choices | None, ...]

    def arguments(self, raw: bytes) -> Arguments:
        """The arguments, from the bytes in an EVENT; missing bytes count as zeros."""
        return struct.unpack_from(self.layout, raw.ljust(struct.calcsize(self.layout), b"\0"))

    def in_words(self, raw: bytes) -> str:
        """The message for people, in one line."""
        text = self._filled(self.template, self.arguments(raw))
        return printable(" ".join(text.split()))[:MOST_TEXT]

    def _filled(self, template: str, arguments: Arguments) -> str:
        def filled(token: re.Match[str]) -> str:
            if token["escaped"] is not None:
                return token["escaped"]
            if token["argument"] is not None:
                return self._argument(token, arguments)
            if token["tag"] == "profile" and not (token["profile"] or "").startswith("!"):
                return ""
            if token["tag"] == "profile":
                return self._filled(token["content"], arguments)
            return token["content"] if token["tag"] in ("a", "param") else ""

        return _TOKEN.sub(filled, template)

    def _argument(self, token: re.Match[str], arguments: Arguments) -> str:
        at = int(token["argument"]) - 1
        if not 0 <= at < len(arguments):
            return token[0]
        value, choices, digits = arguments[at], self.choices[at], token["digits"]
        if choices is not None:
            return choices.in_words(int(value))
        if isinstance(value, int):
            text = str(value)
        else:
            text = f"{value:g}" if digits is None else f"{value:.{digits}f}"
        unit = token["unit"]
        return f"{text} {_UNITS.get(unit, unit)}" if unit else text


@dataclass(frozen=True, slots=True)
class EventMetadata:
    """The metadata of all events of a component.

    Attributes:
        events: definitions by number.
        mode_groups: custom mode of a heartbeat -> the bit that arming checks use for it.
    """

    events: dict[int, EventDefinition]
    mode_groups: dict[int, int]


def events_file(general: bytes) -> str:
    """The URI of the events' metadata, from the general metadata file; on the vehicle if possible.

    Raises:
        MetadataError: the file names none.
    """
    for entry in _items(_load(general).get("metadataTypes")):
        of_type = _mapping(entry)
        if of_type.get("type") == _EVENTS:
            uris = [of_type.get(key) for key in ("uri", "uriFallback")]
            texts = [uri for uri in uris if isinstance(uri, str)]
            if texts:
                return next((uri for uri in texts if uri.startswith("mftp://")), texts[0])
    raise MetadataError("the general metadata names no file for events")


def read_events(content: bytes) -> EventMetadata:
    """Reads the metadata of events.

    Raises:
        MetadataError: it cannot be unpacked or read, or is too large.
    """
    components = _mapping(_load(content).get("components"))
    enums: dict[str, tuple[str, Choices]] = {}
    for component in map(_mapping, components.values()):
        for name, enum in _mapping(component.get("enums")).items():
            if (found := _choices(_mapping(enum))) is not None:
                enums[f"{component.get('namespace')}::{name}"] = found
    events: dict[int, EventDefinition] = {}
    modes: dict[int, int] = {}
    for key, value in components.items():
        number, component = _integer(key), _mapping(value)
        if number is None or not 0 <= number < 256:
            continue
        for group, about in _mapping(component.get("event_groups")).items():
            for sub_key, event in _mapping(_mapping(about).get("events")).items():
                sub_number = _integer(sub_key)
                definition = _definition(component, group, _mapping(event), enums)
                if definition is not None and sub_number is not None:
                    events.setdefault(number << 24 | sub_number & 0xFFFFFF, definition)
        groups = _mapping(_mapping(component.get("navigation_mode_groups")).get("groups"))
        for bit_key, custom_modes in groups.items():
            bit = _integer(bit_key)
            if bit is not None and 0 <= bit < 64:
                modes.update({m: bit for m in _items(custom_modes) if isinstance(m, int)})
    return EventMetadata(events, modes)


def _definition(
    component: dict[str, Any], group: str, event: dict[str, Any], enums: dict[str, Any]
) -> EventDefinition | None:
    """The definition of an event; None if it is not understood."""
    name, template, kind = event.get("name"), event.get("message"), event.get("type", "")
    if not (isinstance(name, str) and isinstance(template, str) and isinstance(kind, str)):
        return None
    codes, choices = "", []
    for argument in map(_mapping, _items(event.get("arguments"))):
        of_type = argument.get("type")
        if not isinstance(of_type, str):
            return None
        scoped = of_type if "::" in of_type else f"{component.get('namespace')}::{of_type}"
        code, enum = (_CODES[of_type], None) if of_type in _CODES else enums.get(scoped, ("", None))
        if not code:
            return None
        codes += code
        choices.append(enum)
        if struct.calcsize(f"<{codes}") > MOST_ARGUMENTS:
            return None
    return EventDefinition(name, group, kind, template[:MOST_TEMPLATE], f"<{codes}", tuple(choices))


def _choices(enum: dict[str, Any]) -> tuple[str, Choices] | None:
    """The code of an enum's type, and the enum; None if it is not understood."""
    code = _CODES.get(str(enum.get("type")), "f")
    separator = enum.get("separator", "|")
    if code == "f" or not isinstance(separator, str):
        return None
    words = {}
    for key, entry in _mapping(enum.get("entries")).items():
        value, about = _integer(key), _mapping(entry)
        word = about.get("description", about.get("name"))
        if value is not None and isinstance(word, str):
            words[value] = word[:MOST_TEXT]
    is_bitfield = enum.get("is_bitfield") is True
    return code, Choices(separator[:8] if is_bitfield else None, words)


def _load(content: bytes) -> dict[str, Any]:
    """The JSON object of a file, plain or xz."""
    try:
        if content.startswith(_XZ):
            unpacker = lzma.LZMADecompressor(lzma.FORMAT_XZ, MOST_MEMORY)
            content = unpacker.decompress(content, MOST_BYTES + 1)
            if len(content) <= MOST_BYTES and not unpacker.eof:
                raise MetadataError("it is cut off")
        if len(content) > MOST_BYTES:
            raise MetadataError(f"it has more than {MOST_BYTES} bytes")
        return _mapping(json.loads(content))
    except (lzma.LZMAError, ValueError, RecursionError, EOFError) as error:
        raise MetadataError(f"it cannot be read: {error}") from error


def _mapping(value: object) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}


def _items(value: object) -> list[Any]:
    return value if isinstance(value, list) else []


def _integer(text: str) -> int | None:
    return int(text) if text.isdecimal() and len(text) < 20 else None
