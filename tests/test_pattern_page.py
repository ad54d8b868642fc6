"""docs/patterns.md: every mission pattern, with what the companion makes of it."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from automaton_picture import picture
from make_patterns import DOCS, PAGE, Example, examples, files, flown

from companion.ltl.parser import parse
from companion.ltl.patterns import PATTERNS
from companion.ltl.semantics import holds
from companion.ltl.translate import translate

TEXT = PAGE.read_text(encoding="utf-8")
SVG = "{http://www.w3.org/2000/svg}"


def test_each_pattern_has_one_section_and_two_pictures() -> None:
    assert [example.name for example in examples(TEXT)] == list(PATTERNS)
    assert [line[3:] for line in TEXT.splitlines() if line.startswith("## ")] == list(PATTERNS)
    pictures = {path for each in examples(TEXT) for path in (each.automata, each.flight)}
    assert pictures == set((DOCS / "patterns").glob("*"))


@pytest.mark.slow
def test_the_page_and_its_pictures_are_current() -> None:
    """If this fails: python scripts/make_patterns.py."""
    expected: dict[Path, str] = files(TEXT)
    for path, text in expected.items():
        assert path.read_text(encoding="utf-8") == text, path.name


@pytest.mark.parametrize("example", examples(TEXT), ids=lambda each: each.name)
def test_the_word_beside_a_flight_satisfies_its_task(example: Example) -> None:
    """By the direct semantics, for ever."""
    prefix, loop = word(example.flight)
    assert prefix[0] == {"at(Home)"} and loop
    for text in (example.text, example.also or "true"):
        assert holds(parse(text), prefix, loop)


@pytest.mark.long
@pytest.mark.parametrize("example", examples(TEXT), ids=lambda each: each.name)
def test_the_pictures_of_flights_are_current(example: Example) -> None:
    """If this fails: python scripts/make_patterns.py."""
    assert example.flight.read_text(encoding="utf-8") == flown(example)


def word(flight: Path) -> tuple[list[frozenset[str]], list[frozenset[str]]]:
    """The letters that a picture shows; those that have the line of the omega are the loop."""
    root = ElementTree.parse(flight).getroot()
    letters = [each for each in root.iter(f"{SVG}text") if each.get("class") == "l"]
    [line] = (each.get("d", "") for each in root.iter(f"{SVG}path") if each.get("class") == "w")
    top = int(line.partition(" ")[2].partition("V")[0])
    read = [(int(each.get("y", "")), frozenset(str(each.text).split(", "))) for each in letters]
    return [text for y, text in read if y < top], [text for y, text in read if y > top]


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
