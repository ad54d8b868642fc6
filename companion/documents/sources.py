"""Where a mission or a scenario comes from: a file, a text, or data.

A door: it opens the file of a path. A text with a line break, or one that begins with a brace, is
YAML; any other text is a path.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from companion.documents.diagnostics import did_you_mean
from companion.documents.yaml_tree import MAX_BYTES
from companion.errors import MissionError

Given = Path | str | Mapping[str, object]
"""A path, a YAML text, or data."""


@dataclass(frozen=True, slots=True)
class Source:
    """What was given, as far as it is known before it is read as YAML.

    Attributes:
        content: a text, or data.
        name: for messages: the path, or words in its place.
        folder: to which file names in it are relative.
        path: the path of its file; None if there is no file.
    """

    content: str | Mapping[str, object]
    name: str
    folder: Path
    path: Path | None


def read_source(given: Given, kind: str, folder: Path | None = None) -> Source:
    """Reads a file, or takes a text or data.

    Args:
        given: a path, a YAML text, or data.
        kind: what it is, for messages.
        folder: to which file names in it are relative; by default the file's own folder, or the
            current one.

    Raises:
        MissionError: the file cannot be read, or `given` is of another type.
    """
    if isinstance(given, Mapping):
        return Source(given, kind, folder or Path(), None)
    if isinstance(given, str) and ("\n" in given or given.lstrip().startswith("{")):
        return Source(given, f"<{kind}>", folder or Path(), None)
    if not isinstance(given, str | Path):
        own = type(given).__name__
        what = f"a {kind} is a path, a YAML text or a dict, and this is of type {own}"
        raise MissionError(what)
    path = Path(given)
    return Source(_text(path, kind), str(path), folder or path.parent, path)


def _text(path: Path, kind: str) -> str:
    """The text of a file; bytes that are not UTF-8 stay, for the YAML reader to locate."""
    try:
        with path.open("rb") as stream:
            return stream.read(MAX_BYTES + 1).decode("utf-8", "surrogateescape")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        advice = f"{path} is a folder: name a file in it" if path.is_dir() else ""
        if isinstance(error, FileNotFoundError):
            near = [each.name for each in path.absolute().parent.glob("*.y*ml")]
            advice = did_you_mean(path.name, near)
        raise MissionError(f"the {kind} {path} cannot be read: {reason}", hint=advice) from error
