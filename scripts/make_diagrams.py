"""Draws state diagrams into the documentation, from the transition tables of the program.

Each diagram is between two lines of a page, and is replaced as a whole:

    <!-- diagram: NAME -->
    <!-- end of diagram: NAME -->

Run it after a change of a table; a test compares the pages with the tables. To draw another table,
add it to DIAGRAMS and the two lines to its page. The input is a sequence of rows with the
attributes of `companion.transitions.StateTransition`: state, event, then, effect.

Usage: python scripts/make_diagrams.py
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from companion.acting.behaviour_tree import marker_states
from companion.acting.sortie import phases
from companion.ground import ftp_sessions, upload_states
from companion.transitions import StateTransition

DOCS = Path(__file__).parent.parent / "docs"
MOST_IN_WORDS = 20
"""Most rows of a diagram whose arrows have events in words; larger ones have numbers."""
Rows = Iterable[StateTransition[Any, Any]]
_Key = tuple[Any, Any, str]


class Diagram(NamedTuple):
    """A table and its page."""

    name: str
    page: str
    rows: Rows


DIAGRAMS = (
    Diagram("sortie", "sortie.md", phases.TRANSITIONS),
    Diagram("marker", "landing.md", marker_states.TRANSITIONS),
    Diagram("upload", "uploads.md", upload_states.TRANSITIONS),
    Diagram("FTP session", "uploads.md", ftp_sessions.TRANSITIONS),
)


def mermaid(rows: Rows) -> str:
    """A Mermaid state diagram (https://mermaid.js.org/syntax/stateDiagram.html).

    Arrows are labelled with their events, or, for a long table, with the numbers of its lines,
    because words would cover the diagram. States without a row of their own are final. A table
    without a row for its beginning begins in the state of its first row.
    """
    rows = list(rows)
    begun = {row.state for row in rows}
    first = [] if None in begun else [_identifier(row.state.value) for row in rows[:1] if row.state]
    final = dict.fromkeys(row.then for row in rows if row.then not in begun)
    arrows: dict[tuple[str, str], list[str]] = {}
    is_long = len(rows) > MOST_IN_WORDS
    numbers = {key: str(number) for number, key in enumerate(_alike(rows), 1)}
    for row in rows:
        before = "[*]" if row.state is None else _identifier(row.state.value)
        label = numbers[_key(row)] if is_long else row.event.value
        arrows.setdefault((before, _identifier(row.then.value)), []).append(label)
    joint = ", " if is_long else "<br/>"
    names = dict.fromkeys(s for row in rows for s in (row.state, row.then) if s is not None)
    titles = [s.value for s in names if _identifier(s.value) != s.value]
    lines = [
        "stateDiagram-v2",
        *(f"    {_identifier(title)}: {title}" for title in titles),
        *(f"    [*] --> {title}" for title in first),
        *(f"    {a} --> {b}: {joint.join(events)}" for (a, b), events in arrows.items()),
        *(f"    {_identifier(state.value)} --> [*]" for state in final),
    ]
    return "\n".join(["```mermaid", *lines, "```"])


def table(rows: Rows) -> str:
    """The rows as a Markdown table.

    In a long table, rows that differ only in their state share a line, and lines have numbers.
    """
    rows = list(rows)
    head = ["state", "event", "next state", "what happens"]
    cells = [[_title(row), row.event.value, row.then.value, row.effect] for row in rows]
    if len(rows) > MOST_IN_WORDS:
        head = ["", *head]
        cells = [
            [str(number), ", ".join(map(_title, alike)), event.value, then.value, effect]
            for number, ((event, then, effect), alike) in enumerate(_alike(rows).items(), 1)
        ]
    lines = [f"| {' | '.join(line)} |" for line in (head, *cells)]
    return "\n".join([lines[0], "|---" * len(head) + "|", *lines[1:]])


def drawn(page: str, diagrams: Mapping[str, Rows]) -> str:
    """The text of a page with its diagrams regenerated.

    Raises:
        ValueError: a diagram has no place in the page.
    """
    for name, rows in diagrams.items():
        begin, end = f"<!-- diagram: {name} -->", f"<!-- end of diagram: {name} -->"
        place = re.compile(f"{re.escape(begin)}\n.*?{re.escape(end)}", re.DOTALL)
        if len(place.findall(page)) != 1:
            raise ValueError(f"the page has not one place for the diagram {name}")
        text = "\n\n".join([begin, mermaid(rows), table(rows), end])
        page = place.sub(lambda _, text=text: text, page)  # type: ignore[misc]
    return page


def pages() -> dict[Path, str]:
    """Each page that has diagrams, as generated."""
    wanted: dict[Path, dict[str, Rows]] = {}
    for diagram in DIAGRAMS:
        wanted.setdefault(DOCS / diagram.page, {})[diagram.name] = diagram.rows
    return {
        page: drawn(page.read_text(encoding="utf-8"), diagrams) for page, diagrams in wanted.items()
    }


def _alike(rows: Rows) -> dict[_Key, list[StateTransition[Any, Any]]]:
    """The rows, grouped if they differ only in state, in the order of the first of each group."""
    alike: dict[_Key, list[StateTransition[Any, Any]]] = {}
    for row in rows:
        alike.setdefault(_key(row), []).append(row)
    return alike


def _key(row: StateTransition[Any, Any]) -> _Key:
    """All of a row but its state."""
    return row.event, row.then, row.effect


def _title(row: StateTransition[Any, Any]) -> str:
    """The state of a row, in words."""
    return row.state.value if row.state else "none yet"


def _identifier(title: str) -> str:
    """A state's title as an identifier of Mermaid: one word."""
    return re.sub(r"\W+", "_", title)


if __name__ == "__main__":
    for page, text in pages().items():
        page.write_text(text, encoding="utf-8")
        print(f"wrote {page}")
