"""Reads untrusted YAML as a tree of plain values, in which every node knows its place.

The size of the text is limited before it is read, and its depth while it is read. Anchors, aliases,
tags, directives, second documents, duplicate keys and numbers that are not finite are refused, so
that a person and the program read the same. A refused value does not end the reading: it is
reported with the other mistakes.

Plain scalars follow the core schema of YAML 1.2.2, section 10.3.2: only `true` and `false` are
truth values, so a place may be called `no` or `on`; a date is a text. Keys are always texts. The
tokens come from ruamel.yaml. Left out: the meaning of values (document.py).
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError
from ruamel.yaml.events import (
    AliasEvent,
    DocumentStartEvent,
    Event,
    MappingEndEvent,
    MappingStartEvent,
    NodeEvent,
    ScalarEvent,
    SequenceEndEvent,
    SequenceStartEvent,
    StreamEndEvent,
)
from ruamel.yaml.reader import ReaderError

from companion.errors import KeyPath, Keys, Location, MissionError

MAX_BYTES = 64 * 1024  # a mission of 100 places has 10 KiB; a parser's time grows with the size
MAX_DEPTH = 16  # our own files nest 5 deep; the tree is read by recursion

Value = str | int | float | bool | None


@dataclass(frozen=True, slots=True)
class ScalarNode:
    """One value; `start` and `end` are indices into the text, quotes and markers included."""

    where: Location | KeyPath
    value: Value
    start: int
    end: int


@dataclass(frozen=True, slots=True)
class SequenceNode:
    """A YAML sequence."""

    where: Location | KeyPath
    items: tuple[Node, ...]


@dataclass(frozen=True, slots=True)
class MappingEntry:
    """One key of a mapping with its value."""

    key_at: Location | KeyPath
    node: Node


@dataclass(frozen=True, slots=True)
class MappingNode:
    """A YAML mapping."""

    where: Location | KeyPath
    entries: dict[str, MappingEntry]


Node = ScalarNode | SequenceNode | MappingNode
Refused = dict[Keys, MissionError]
"""Keys of values that are refused, and empty in the tree -> why."""


def read_tree(text: str, path: str) -> tuple[Node, Refused]:
    """The tree of a YAML text, and its refused values.

    Args:
        text: line breaks are "\\n", no byte order mark.
        path: name of the file, only for messages.

    Raises:
        MissionError: too large, too deep, or not YAML.
    """
    if len(text.encode("utf-8", "surrogatepass")) > MAX_BYTES:
        raise MissionError(
            f"the file is larger than {MAX_BYTES} bytes",
            Location(path, 1, 1),
            "split the mission, or check that this is the right file",
        )
    try:
        reader = _TreeReader(path, YAML(typ="safe", pure=True).parse(text))
        return reader.read(), reader.refused
    except ReaderError as error:
        line = text.count("\n", 0, error.position) + 1
        column = error.position - text.rfind("\n", 0, error.position)
        code = ord(text[error.position])
        raise MissionError(
            "the file is not UTF-8 text"
            if 0xDC80 <= code <= 0xDCFF  # Python's form of a byte that could not be decoded
            else f"character U+{code:04X} is not allowed in YAML",
            Location(path, line, column),
            "remove this character, or save the file as UTF-8",
        ) from None
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        if "end of stream" in str(error.problem):
            mark = error.context_mark or mark
        where = Location(path, mark.line + 1, mark.column + 1) if mark else Location(path, 1, 1)
        problem = str(error.problem or error.context or "not YAML")
        hint = _hidden_fault(text, where.line) or _syntax_hint(problem, error)
        raise MissionError(f"not YAML: {problem}", where, hint) from None
    except (ValueError, OverflowError):  # from chr() for an escape "\\U" with too large a number
        raise MissionError("an escape \\U gives no character", Location(path, 1, 1)) from None


_SYNTAX_HINTS = (
    ("',' or '}'", "inside { } put quotes around a text that contains , [ ] { or }"),
    ("',' or ']'", "inside [ ] put quotes around a text that contains , [ ] { or }"),
    ("mapping values", "put quotes around a text that contains ': ', and check the indentation"),
    ("\\t", "indent with spaces: YAML allows no tabs"),
    ("cannot start any token", "put quotes around a text that begins with this character"),
    ("end of stream", "a quote or bracket is opened here and never closed"),
    ("simple key", "the ':' after the key is missing, or a key spans two lines"),
    ("<block end>", "check the indentation: keys of one mapping begin in the same column"),
)
"""Part of ruamel's message -> advice."""


_NO_SPACE = re.compile(r"^\s*([A-Za-z_]\w*):([^\s/:].*?)\s*$")
"""A key without a space after its colon."""


_EQUALS = re.compile(r"^\s*([A-Za-z_]\w*)\s*=\s*(\S.*?)\s*$")
"""A key with an equals sign."""
_DASH = re.compile(r"^\s*[\u2010-\u2015\u2022\u2212]\s")
"""An entry of a list with a dash or a bullet of a word processor."""
_TAG = re.compile(r"[\[{,]\s*![A-Za-z(]")
"""A text with ! inside brackets."""


def _syntax_hint(problem: str, error: MarkedYAMLError) -> str:
    hint = next((hint for part, hint in _SYNTAX_HINTS if part in problem), "")
    begun, met = error.context_mark, error.problem_mark
    if begun and met and begun.line < met.line and "or '" in problem:
        return f"what is opened in line {begun.line + 1} is not closed, or {hint}"
    return hint


def _hidden_fault(text: str, number: int) -> str:
    """A mistake that is hard to see, in the line of an error or in the one before."""
    lines = text.split("\n")
    for n in (number - 1, number):
        line = lines[n - 1] if 0 < n <= len(lines) else ""
        if strange := [c for c in line if c.isspace() and c not in " \t\r"]:
            what = f"U+{ord(strange[0]):04X}, which only looks like a space"
            return f"line {n} has {what}: write a plain space"
        if found := _NO_SPACE.match(line):
            return f"line {n} lacks a space after the colon: write {found[1]}: {found[2]}"
        if found := _EQUALS.match(line):
            return f"line {n} has = after a key: write {found[1]}: {found[2]}"
        if _DASH.match(line):
            return (
                f"line {n} begins with a dash of a word processor: write the minus of the keyboard"
            )
        if _TAG.search(line):
            return f"line {n} has a text that begins with !: put quotes around it, e.g. '!at(A)'"
    return ""


class _TreeReader:
    """Builds the tree from the parser's events, by recursive descent."""

    def __init__(self, path: str, events: Iterator[Event]) -> None:
        self._path = path
        self._events = events
        self.refused: Refused = {}

    def read(self) -> Node:
        next(self._events)  # start of the stream
        start = next(self._events)
        if isinstance(start, StreamEndEvent):
            advice = "companion new NAME writes a mission to start from"
            raise MissionError("the file is empty", Location(self._path, 1, 1), advice)
        assert isinstance(start, DocumentStartEvent)
        if start.version or start.tags:
            raise MissionError(
                "YAML directives are not allowed",
                Location(self._path, 1, 1),
                "remove the lines that begin with %",
            )
        root = self._node(next(self._events), ())
        next(self._events)  # end of the document
        if not isinstance(after := next(self._events), StreamEndEvent):
            raise MissionError(
                "a second YAML document begins here",
                self._where(after),
                "one file holds one document: remove the line ---",
            )
        return root

    def _where(self, event: Event) -> Location:
        return Location(self._path, event.start_mark.line + 1, event.start_mark.column + 1)

    def _node(self, event: Event, keys: Keys) -> Node:
        where = self._where(event)
        if len(keys) >= MAX_DEPTH:
            raise MissionError(f"nested deeper than {MAX_DEPTH} levels", where)
        try:
            _refuse_references(event, where)
        except MissionError as error:
            self.refused.setdefault(keys, error)
        if isinstance(event, SequenceStartEvent):
            return self._sequence(where, keys)
        if isinstance(event, MappingStartEvent):
            return self._mapping(where, keys)
        start, end = event.start_mark.index, event.end_mark.index
        if keys in self.refused or not isinstance(event, ScalarEvent):
            return ScalarNode(where, None, start, end)
        try:
            _refuse_surrogates(event.value, where)
            value = event.value if event.style else _plain_value(event.value, where)
        except MissionError as error:
            self.refused[keys], value = error, None
        return ScalarNode(where, value, start, end)

    def _sequence(self, where: Location, keys: Keys) -> SequenceNode:
        items: list[Node] = []
        while not isinstance(event := next(self._events), SequenceEndEvent):
            items.append(self._node(event, (*keys, len(items))))
        return SequenceNode(where, tuple(items))

    def _mapping(self, where: Location, keys: Keys) -> MappingNode:
        entries: dict[str, MappingEntry] = {}
        lines: dict[str, int] = {}
        while not isinstance(event := next(self._events), MappingEndEvent):
            key_at = self._where(event)
            _refuse_references(event, key_at)
            if not isinstance(event, ScalarEvent):
                raise MissionError(
                    "a key must be a text",
                    key_at,
                    "put quotes around a text that begins with [ or {",
                )
            _refuse_surrogates(key := event.value, key_at)
            node = self._node(next(self._events), (*keys, key))
            if key in entries:
                hint = f"first given in line {lines[key]}; keep one of them"
                error = MissionError(f"the key {key} is given twice", key_at, hint)
                self.refused.setdefault((*keys, key), error)
                continue
            if isinstance(node, ScalarNode) and node.start == node.end:  # an empty value
                node = ScalarNode(key_at, node.value, node.start, node.end)
            entries[key], lines[key] = MappingEntry(key_at, node), key_at.line
        return MappingNode(where, entries)


def _refuse_surrogates(text: str, where: Location) -> None:
    if re.search("[\ud800-\udfff]", text):
        raise MissionError(
            "an escape \\u gives half of a surrogate pair, which is not a character",
            where,
            "write the character itself, or \\U with 8 digits",
        )


def _refuse_references(event: Event, where: Location) -> None:
    if isinstance(event, AliasEvent):
        raise MissionError(
            f"YAML alias *{event.anchor} is not allowed",
            where,
            "write the value again, or put quotes around a text that begins with *",
        )
    assert isinstance(event, NodeEvent)
    if event.anchor is not None:
        raise MissionError(
            f"YAML anchor &{event.anchor} is not allowed",
            where,
            "remove it, or put quotes around a text that begins with &",
        )
    tag = getattr(event, "tag", None)
    if tag is not None:
        raise MissionError(
            f"YAML tag {tag} is not allowed",
            where,
            "put quotes around a text that begins with !, e.g. '!at(A)'",
        )


_WORDS: dict[str, Value] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}
_INTEGER = re.compile(r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
_LONGEST_NUMBER = 40  # characters; no quantity of ours needs more


def _plain_value(text: str, where: Location) -> Value:
    """The value of a scalar without quotes (YAML 1.2.2, 10.3.2)."""
    if text in _WORDS:
        return _WORDS[text]
    if _NOT_FINITE.fullmatch(text):
        raise MissionError(f"{text} is not a finite number", where)
    is_integer = _INTEGER.fullmatch(text) is not None
    if not is_integer and not _FLOAT.fullmatch(text):
        return text
    if len(text) > _LONGEST_NUMBER:
        raise MissionError(f"a number of {len(text)} characters is too long", where)
    if is_integer:
        return int(text, {"0o": 8, "0x": 16}.get(text[:2], 10))
    number = float(text)
    if not math.isfinite(number):
        raise MissionError(f"{text} is not a finite number", where, "it is too large")
    return number
