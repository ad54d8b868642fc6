"""YAML from outside: what is read, what is refused, and where its characters lie."""

from __future__ import annotations

import json
from typing import Annotated, Literal

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from pydantic import BaseModel, ConfigDict, Field

from companion.documents import TextDocument, validate
from companion.documents.yaml_tree import MAX_BYTES, MAX_DEPTH
from companion.errors import FormulaError, Location, MissionError


class Part(BaseModel):
    model_config = ConfigDict(extra="forbid")

    weight_kg: Annotated[float, Field(gt=0, description="Mass of the part.")]
    colour: Literal["red", "green"] = "red"
    corner: tuple[float, float] = (0.0, 0.0)


class Kit(BaseModel):
    model_config = ConfigDict(extra="forbid")

    title: str
    parts: dict[str, Part] = {}
    count: int | Literal["many"] = 1
    is_open: bool = False


class Anything(BaseModel):
    model_config = ConfigDict(extra="allow")


def error_of(text: str) -> MissionError:
    with pytest.raises(MissionError) as caught:
        validate(text, "kit.yaml", Kit)
    return caught.value


@pytest.mark.parametrize(
    ("text", "line", "column", "what", "hint"),
    [
        ("title: a\nparst: {}", 2, 1, "unknown key 'parst'", "Did you mean parts?"),
        ("parts: {}", 1, 1, "the key title is missing", ""),
        ("title: 5", 1, 8, "title is 5, expected a text", ""),
        ("title:\ncount: 1", 1, 1, "title is empty, expected a text", ""),
        ("title: a\ncount: x", 2, 8, "expected a whole number or many", ""),
        ("title: a\ncount: 1.0", 2, 8, "expected a whole number or many", ""),
        ("title: a\nis_open: 1", 2, 10, "is_open is 1, expected true or false", ""),
        ("title: a\nparts: [1]", 2, 8, "parts is a list, expected keys with values", ""),
        ("title: a\nparts:\n  p: {}", 3, 3, "the key weight_kg is missing in parts.p", "Mass"),
        ("title: a\nparts:\n  p: {weight_kg: 0}", 3, 18, "expected more than 0", "Mass"),
        (
            "title: a\nparts: {p: {weight_kg: 1, colour: gren}}",
            2,
            35,
            "colour is 'gren', expected red or green",
            "Did you mean green?",
        ),
        (
            "title: a\nparts: {p: {weight_kg: 1, corner: [0, x]}}",
            2,
            39,
            "entry 2 in parts.p.corner is 'x', expected a number",
            "",
        ),
        ("[1, 2]", 1, 1, "the file is a list, expected keys with values", ""),
        ("just text", 1, 1, "the file is 'just text', expected keys with values", ""),
        ("# nothing\n", 1, 1, "the file is empty", ""),
    ],
)
def test_problem_is_told_in_plain_words(
    text: str, line: int, column: int, what: str, hint: str
) -> None:
    error = error_of(text)
    assert error.where == Location("kit.yaml", line, column)
    assert what in error.what
    assert hint in error.hint


def test_first_problem_in_the_file_is_told() -> None:
    assert error_of("title: a\nis_open: 1\ncount: x").where == Location("kit.yaml", 2, 10)


# What the YAML parser must never pass on: the traps that PyYAML falls into.


def test_size_is_limited_before_anything_is_parsed() -> None:
    assert "larger than 65536 bytes" in error_of("[" * 200_000).what
    assert "larger than" in error_of("a" * MAX_BYTES + "\n").what
    assert "larger than" in error_of("é" * (MAX_BYTES // 2 + 1)).what


@pytest.mark.parametrize(
    "opening",
    [
        "[",
        "{a: ",
        "- ",
        pytest.param("? ", marks=pytest.mark.long),
        pytest.param("[\n", marks=pytest.mark.long),
        pytest.param("[a,[", marks=pytest.mark.long),
    ],
)
def test_depth_is_limited(opening: str) -> None:
    error = error_of(opening * (MAX_BYTES // len(opening)))
    assert f"nested deeper than {MAX_DEPTH} levels" in error.what or "a key must" in error.what


@pytest.mark.parametrize(
    ("text", "line", "column", "what"),
    [
        ("a: &x 1", 1, 4, "anchor &x"),
        ("a: 1\nb: *x", 2, 4, "alias *x"),
        ("a: !!python/object:os.system x", 1, 4, "tag"),
        ("!x a: 1", 1, 1, "tag !x"),
        ("a: !x [1]", 1, 4, "tag !x"),
        ("a: 1\n b: 2", 2, 3, "mapping values are not allowed"),
        ("a: 1\nb: 2\na: 3", 3, 1, "the key a is given twice"),
        ("a: 1\n'a': 3", 2, 1, "the key a is given twice"),
        ("b: {a: 1, a: 3}", 1, 11, "the key a is given twice"),
        ("[1]: 2", 1, 1, "a key must be a text"),
        ("%YAML 1.1\n---\na: 1", 1, 1, "directives"),
        ("a: 1\n---\nb: 2", 2, 1, "second YAML document"),
        ("a: .nan", 1, 4, "not a finite number"),
        ("a: [1, -.inf]", 1, 8, "not a finite number"),
        ("a: 1e999", 1, 4, "not a finite number"),
        ("a: " + "9" * 5000, 1, 4, "too long"),
        ('a: "\\ud800"', 1, 4, "surrogate"),
        ('"\\ud800": 1', 1, 1, "surrogate"),
        ('a: "\\UFFFFFFFF"', 1, 1, "gives no character"),
        ("a: 1\nb: \x00", 2, 4, "U+0000"),
        ("a:\n\t- 1", 2, 1, "cannot start any token"),
    ],
)
def test_unsafe_yaml_is_refused(text: str, line: int, column: int, what: str) -> None:
    with pytest.raises(MissionError) as caught:
        validate(text, "f", Anything)
    assert caught.value.where == Location("f", line, column)
    assert what in caught.value.what


def test_what_is_refused_is_told_with_what_else_is_wrong() -> None:
    error = error_of("title: !a\nis_open: 1\nparts: {p: {weight_kg: .inf}}\ncount: 2\ncount: 3")
    assert [each.what for each in error.each] == [
        "YAML tag !a is not allowed",
        "is_open is 1, expected true or false",
        ".inf is not a finite number",
        "the key count is given twice",
    ]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        *((word, word) for word in ("no", "on", "off", "yes", "y", "12:30:45", "2024-01-01")),
        *((word, word) for word in ("1_000", "0b1", "<<", "=", "nan", "inf", "e3", "1e", ".")),
        ("017", 17),
        ("0o17", 15),
        ("0x1F", 31),
        ("1e3", 1000.0),
        ("-.5", -0.5),
        ("5.", 5.0),
        ("true", True),
        ("FALSE", False),
        ("~", None),
        ("'1'", "1"),
        ('"true"', "true"),
    ],
)
def test_plain_scalars_follow_yaml_1_2(text: str, value: object) -> None:
    read = TextDocument(f"key: {text}", "f").data()
    assert read == {"key": value}
    assert type(read["key"]) is type(value)


def test_keys_are_always_texts() -> None:
    assert TextDocument("no: 1\n1: 2\ntrue: 3\n~: 4", "f").data() == {
        "no": 1,
        "1": 2,
        "true": 3,
        "~": 4,
    }


PRINTABLE = st.text(st.characters(exclude_categories=("C", "Zl", "Zp")))
JSON = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**53), 2**53) | st.floats(-1e9, 1e9) | PRINTABLE,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(PRINTABLE, inner, max_size=4),
    max_leaves=12,
)


@given(value=JSON)
def test_json_means_the_same(value: object) -> None:
    """YAML 1.2 is a superset of JSON."""
    assume(_longest_key(value) < 200)  # YAML limits a key on one line to 1024 characters
    assert TextDocument(json.dumps(value, ensure_ascii=False), "f").data() == value


def _longest_key(value: object) -> int:
    if isinstance(value, dict):
        return max([0, *(len(json.dumps(k)) for k in value), *map(_longest_key, value.values())])
    return max([0, *map(_longest_key, value)]) if isinstance(value, list) else 0


# Where things are.

PLACES = TextDocument("a: {b: [1, x]}\nc:\n  d: 'text'\ne:\n", "f")


@pytest.mark.parametrize(
    ("keys", "value_at", "key_at"),
    [
        (("a",), (1, 4), (1, 1)),
        (("a", "b"), (1, 8), (1, 5)),
        (("a", "b", 1), (1, 12), (1, 12)),
        (("a", "b", 7), (1, 8), (1, 5)),
        (("c", "d"), (3, 6), (3, 3)),
        (("c", "none"), (3, 3), (2, 1)),
        (("c", "none", "deeper"), (3, 3), (2, 1)),
        (("e",), (4, 1), (4, 1)),
        ((), (1, 1), (1, 1)),
    ],
)
def test_keys_and_values_are_found(
    keys: tuple[str | int, ...], value_at: tuple[int, int], key_at: tuple[int, int]
) -> None:
    assert PLACES.where(*keys) == Location("f", *value_at)
    assert PLACES.key_at(*keys) == Location("f", *key_at)


WORDS = st.lists(st.text("abcXYZ()&|!", min_size=1, max_size=8), min_size=1, max_size=12)


def _written(style: str, words: list[str], breaks: list[bool]) -> str:
    """A scalar of some words, broken into lines where `breaks` says so."""
    separators = ["\n   " if b and style != "one line" else "  " for b in breaks]
    body = "".join(w + s for w, s in zip(words, [*separators[: len(words) - 1], ""], strict=True))
    opening = {"'": "'", '"': '"', "|": "|  # why\n   ", ">": ">-\n   "}.get(style, "")
    return opening + body + (style if style in "'\"" else "")


@given(
    style=st.sampled_from(["'", '"', "|", ">", "plain", "one line"]),
    words=WORDS,
    breaks=st.lists(st.booleans(), min_size=12, max_size=12),
    data=st.data(),
)
def test_every_character_of_a_scalar_is_found_in_the_file(
    style: str, words: list[str], breaks: list[bool], data: st.DataObject
) -> None:
    """The character at `inside(offset)` is the one at `offset` of the value."""
    words = [f"w{i}:{word}" for i, word in enumerate(words)]  # no two alike, no YAML indicators
    text = f"# é 😀\nkey: [0]\nformula: {_written(style, words, breaks)}\nafter: 1\n"
    document = TextDocument(text, "f")
    value = document.data()["formula"]  # type: ignore[index,call-overload]
    assert isinstance(value, str)
    assert value.split() == words
    offset = data.draw(st.sampled_from([i for i, c in enumerate(value) if not c.isspace()]))
    where = document.inside(offset, "formula")
    assert isinstance(where, Location)
    lines = text.split("\n")
    assert lines[where.line - 1][where.column - 1 :].startswith(value[offset:].split()[0])


def test_end_of_a_scalar_is_after_its_last_character() -> None:
    assert TextDocument("k: 'ab'", "f").inside(2, "k") == Location("f", 1, 7)
    assert TextDocument("k: >\n  a\n  b\n", "f").inside(4, "k") == Location("f", 3, 4)


def test_a_scalar_with_escapes_is_found_by_its_start() -> None:
    assert TextDocument('k: "a\\tb"', "f").inside(2, "k") == Location("f", 1, 4)
    assert TextDocument("k: 'it''s'", "f").inside(4, "k") == Location("f", 1, 4)
    assert TextDocument("k: 5", "f").inside(0, "k") == Location("f", 1, 4)


def test_formula_errors_are_given_their_place() -> None:
    document = TextDocument("k: G at(D)", "f")
    with pytest.raises(FormulaError) as caught, document.locating("k"):
        raise FormulaError("unknown fact at(D)", "G at(D)", 2, 5)
    assert caught.value.where == Location("f", 1, 6)
