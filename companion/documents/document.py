"""Reads a YAML text, or Python values, as a pydantic model.

The result is the validated model and a `Document`, which finds the place of each key and value for
later checks: line and column in a text, the path of keys in data. No file is opened here. Missions
and the simulator's scenarios are read by this module.

yaml_tree.py reads the YAML itself, with limits of size and depth. Validation is strict, as for
JSON: a quoted "3" is not a number. Messages say in plain words what was expected; their hint is the
field's description, as in the JSON Schema.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TypeAlias, TypeVar

from pydantic import BaseModel, ValidationError

from companion.documents.data_tree import tree_of
from companion.documents.diagnostics import Diagnostic, diagnostics
from companion.documents.readable import StandIns, strictly, what_is_readable, without
from companion.documents.reading import DocumentReading
from companion.documents.yaml_tree import (
    MappingNode,
    Node,
    Refused,
    ScalarNode,
    SequenceNode,
    Value,
    read_tree,
)
from companion.errors import FormulaError, KeyPath, Location, MissionError

Key = str | int
Data: TypeAlias = "Value | list[Data] | dict[str, Data]"
M = TypeVar("M", bound=BaseModel)


def validate(content: str | Mapping[str, object], name: str, model: type[M]) -> tuple[M, Document]:
    """Reads a YAML text, or data, as a model.

    Args:
        content: the whole text, or the data.
        name: the name of the text's file, only for messages.
        model: forbids unknown keys (extra="forbid").

    Raises:
        MissionError: the text is no safe YAML, the data cannot be written as YAML, or it does not
            fit the model.
    """
    value, document, reading = begin_reading(content, name, model, {})
    reading.tell()
    return value, document


def begin_reading(
    content: str | Mapping[str, object], name: str, model: type[M], stand_ins: StandIns
) -> tuple[M, Document, DocumentReading]:
    """Reads as much of a YAML text, or data, as possible, for checks that find more mistakes.

    Args:
        content, name, model: as in `validate`.
        stand_ins: values in place of parts that are needed but could not be read.

    Returns:
        The model, the document, and what is wrong or unread so far.

    Raises:
        MissionError: the text is no safe YAML, the data cannot be written as YAML, or nothing of it
            fits the model.
    """
    if isinstance(content, str):
        document: Document = TextDocument(content, name)
    else:
        document = Document(tree_of(content))
    mistakes = list(document.refused.values())
    data, refused = without(document.data(), document.refused, stand_ins)
    try:
        return strictly(model, data), document, DocumentReading(mistakes, refused)
    except ValidationError as error:
        found = diagnostics(error, model, data, document.position, refused)
        mistakes += [document.refusal(each) for each in found]
        rest = what_is_readable(model, data, error, stand_ins)
        if rest is None:
            DocumentReading(mistakes).tell()
            raise
        return rest[0], document, DocumentReading(mistakes, refused | rest[1])


class Document:
    """A tree of values in which every key and value can be located.

    Args:
        root: the root of the tree.
        refused: invalid values, which are empty in the tree.
    """

    def __init__(self, root: Node, refused: Refused | None = None) -> None:
        self._root = root
        self.refused = refused or {}

    def data(self) -> Data:
        """The content as plain dicts, lists and scalars."""
        return _plain(self._root)

    def refusal(self, found: Diagnostic) -> MissionError:
        """A mistake with its place."""
        at = self.key_at if found.is_about_key else self.where
        return MissionError(found.what, at(*found.keys), found.hint)

    def where(self, *keys: Key) -> Location | KeyPath:
        """The place of a value, or of the nearest parent that exists."""
        return self._nearest(keys)[0].where

    def key_at(self, *keys: Key) -> Location | KeyPath:
        """The place of a key itself, of the item for an index, or of the nearest parent."""
        parent, _ = self._nearest(keys[:-1])
        if keys and isinstance(parent, MappingNode) and str(keys[-1]) in parent.entries:
            return parent.entries[str(keys[-1])].key_at
        return self.where(*keys) if self._nearest(keys)[1] else self.key_at(*keys[:-1])

    def inside(self, offset: int, *keys: Key) -> Location | KeyPath:
        """The place of one character of a scalar, or of the scalar if that is unknown."""
        return self.where(*keys)

    @contextmanager
    def locating(self, *keys: Key) -> Iterator[None]:
        """Gives formula errors in this context their place in this scalar."""
        try:
            yield
        except FormulaError as error:
            first, *others = [
                each.located(self.inside(each.offset, *keys))
                if isinstance(each, FormulaError)
                else each
                for each in error.each
            ]
            raise first.beside(others) from None

    def position(self, *keys: Key) -> tuple[int, ...]:
        """The rank of a value in the order of the document, as a sort key."""
        node, order = self._root, []
        for key in keys:
            if isinstance(node, MappingNode) and str(key) in node.entries:
                order.append(list(node.entries).index(str(key)))
                node = node.entries[str(key)].node
            elif isinstance(node, SequenceNode) and isinstance(key, int) and key < len(node.items):
                order.append(key)
                node = node.items[key]
        return tuple(order)

    def _nearest(self, keys: tuple[Key, ...]) -> tuple[Node, bool]:
        """The node at the keys and True, or the nearest parent and False."""
        node = self._root
        for key in keys:
            if isinstance(node, MappingNode) and str(key) in node.entries:
                node = node.entries[str(key)].node
            elif isinstance(node, SequenceNode) and isinstance(key, int) and key < len(node.items):
                node = node.items[key]
            elif isinstance(node, ScalarNode) and key in (0, keys[-1]):
                continue  # a single text may stand for a list, or a mapping of it
            else:
                return node, False
        return node, True


class TextDocument(Document):
    """A YAML text.

    Args:
        text: the whole file.
        path: its name, only for messages.

    Raises:
        MissionError: the text is no safe YAML (see yaml_tree.py).
    """

    def __init__(self, text: str, path: str) -> None:
        self._text = text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")
        self._path = path
        super().__init__(*read_tree(self._text, path))

    def inside(self, offset: int, *keys: Key) -> Location | KeyPath:
        """The place of one character of a scalar, however the scalar is written.

        YAML folds lines and drops indentation but keeps every other character, so the n-th
        character that is not white space is the same in the file and in the value.

        Args:
            offset: index into the value; its end is allowed.
            keys: where the scalar is.

        Returns:
            The start of the scalar if it has escapes, because then positions do not correspond.
        """
        node, is_found = self._nearest(keys)
        if not is_found or not isinstance(node, ScalarNode) or not isinstance(node.value, str):
            return node.where
        inner = self._inner_start(node)
        indices = [i for i in range(inner, node.end) if not self._text[i].isspace()]
        value = "".join(node.value.split())
        if "".join(self._text[i] for i in indices[: len(value)]) != value or not value:
            return node.where
        rank = len("".join(node.value[:offset].split()))
        index = indices[rank] if rank < len(value) else indices[len(value) - 1] + 1
        line = self._text.count("\n", 0, index) + 1
        return Location(self._path, line, index - self._text.rfind("\n", 0, index))

    def _inner_start(self, scalar: ScalarNode) -> int:
        """The index after the opening quote, or after the header line of a block scalar."""
        opening = self._text[scalar.start]
        if opening in "|>":
            return self._text.index("\n", scalar.start)
        return scalar.start + (opening in "\"'")


def _plain(node: Node) -> Data:
    if isinstance(node, ScalarNode):
        return node.value
    if isinstance(node, SequenceNode):
        return [_plain(item) for item in node.items]
    return {key: _plain(entry.node) for key, entry in node.entries.items()}
