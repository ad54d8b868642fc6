"""docs/patterns.md: every mission pattern, with what the companion makes of it."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from automaton_picture import picture
from make_patterns import DOCS, PAGE, examples, files

from companion.ltl.parser import parse
from companion.ltl.patterns import PATTERNS
from companion.ltl.translate import translate

TEXT = PAGE.read_text(encoding="utf-8")
SVG = "{http://www.w3.org/2000/svg}"


def test_each_pattern_has_one_section_and_one_picture() -> None:
    assert [example.name for example in examples(TEXT)] == list(PATTERNS)
    assert [line[3:] for line in TEXT.splitlines() if line.startswith("## ")] == list(PATTERNS)
    pictures = {path.stem for path in (DOCS / "patterns").glob("*")}
    assert pictures == set(PATTERNS)


@pytest.mark.slow
def test_the_page_and_its_pictures_are_current() -> None:
    """If this fails: python scripts/make_patterns.py."""
    expected: dict[Path, str] = files(TEXT)
    for path, text in expected.items():
        assert path.read_text(encoding="utf-8") == text, path.name


def test_a_picture_has_each_state_edge_and_label() -> None:
    automaton = translate(parse("G(a -> X b) & c U d"))
    root = ElementTree.fromstring(picture([automaton]))
    texts = [each.text for each in root.iter(f"{SVG}text")]
    labels = [str(each.label) for each in automaton.transitions]
    assert all(any(str(text).startswith(label) for text in texts) for label in labels)
    drawn = len(list(root.iter(f"{SVG}path"))) - 1  # the arrow's head
    edges = {(each.source, each.target) for each in automaton.transitions}
    assert drawn == len(edges) + len(automaton.initial)
    circles = {each.get("cx") for each in root.iter(f"{SVG}circle")}
    assert len(circles) == automaton.states
