"""Cubes as sets of letters and back, exclusive propositions, and the order of cubes."""

from __future__ import annotations

import os
from itertools import product
from pathlib import Path

import pytest
from drawn_graphs import CUBES
from hypothesis import given
from hypothesis import strategies as st
from mypy import api as mypy

from companion.ltl import labels
from companion.ltl.automaton import Label
from companion.ltl.labels import MAX_LETTERS, Alphabet, Cube, CubeOrder, LetterSet, joined

NAMES = ("a", "b", "c", "d")
PLAIN = Alphabet(NAMES)
PLACES = Alphabet(NAMES, frozenset("abd"))
LABELS = st.builds(
    lambda signs: Label(
        frozenset(name for name, sign in zip(NAMES, signs, strict=True) if sign == 1),
        frozenset(name for name, sign in zip(NAMES, signs, strict=True) if sign == -1),
    ),
    st.tuples(*[st.sampled_from([-1, 0, 1])] * 4),
)


def letters(alphabet: Alphabet) -> dict[LetterSet, frozenset[str]]:
    """Each letter, by its bit: what reads no other cube of all four propositions."""
    found = {}
    for signs in product([False, True], repeat=4):
        held = frozenset(name for name, sign in zip(NAMES, signs, strict=True) if sign)
        bits = alphabet.letters(alphabet.cube(Label(held, frozenset(NAMES) - held)))
        if bits:
            found[bits] = held
    return found


def test_letters_with_two_exclusive_propositions_do_not_occur() -> None:
    assert len(letters(PLAIN)) == 16
    assert sorted(map(sorted, letters(PLACES).values())) == [
        [], ["a"], ["a", "c"], ["b"], ["b", "c"], ["c"], ["c", "d"], ["d"],
    ]  # fmt: skip
    for alphabet in (PLAIN, PLACES):
        assert all(bits.bit_count() == 1 for bits in letters(alphabet))
        assert sum(map(int, letters(alphabet))) == int(alphabet.every)


@given(LABELS, st.sampled_from([PLAIN, PLACES]))
def test_a_cube_reads_the_letters_that_its_label_matches(label: Label, alphabet: Alphabet) -> None:
    cube = alphabet.cube(label)
    assert alphabet.label(cube) == label
    matched = sum(int(bits) for bits, held in letters(alphabet).items() if label.matches(held))
    assert int(alphabet.letters(cube)) == matched


@given(st.data(), st.sampled_from([PLAIN, PLACES]))
def test_cubes_read_a_set_of_letters_without_overlap(
    data: st.DataObject, alphabet: Alphabet
) -> None:
    wanted = data.draw(st.integers(0, int(alphabet.every)))
    parts = [int(alphabet.letters(cube)) for cube in alphabet.cubes(LetterSet(wanted))]
    assert sum(parts) == wanted  # no carry: they are disjoint
    assert sum(map(int.bit_count, parts)) == wanted.bit_count()


def test_a_place_is_one_literal() -> None:
    places = [f"p{i}" for i in range(50)]
    alphabet = Alphabet(places, frozenset(places))
    cube = alphabet.cube(Label(frozenset({"p7"}), frozenset()))
    fresh = Alphabet(places, frozenset(places))
    assert fresh.cubes(alphabet.letters(cube)) == [cube]


def test_fifty_places_are_few_letters_and_fifty_propositions_are_not() -> None:
    places = [f"p{i}" for i in range(50)]
    assert Alphabet([*places, "q", "r"], frozenset(places)).is_small
    assert not Alphabet(places).is_small
    assert Alphabet(places[: MAX_LETTERS.bit_length() - 1]).is_small


@given(st.sets(CUBES))
def test_joined_cubes_read_the_same_letters_and_are_no_more(cubes: set[Cube]) -> None:
    alphabet = Alphabet(("a", "b"))
    fewer = joined(cubes)
    read = [sum({1 << i for c in some for i in range(4) if int(alphabet.letters(c)) >> i & 1})
            for some in (cubes, fewer)]  # fmt: skip
    assert read[0] == read[1]
    assert len(fewer) <= len(cubes)


@given(st.sets(CUBES, min_size=1), st.data())
def test_the_order_of_cubes_says_what_includes_what(cubes: set[Cube], data: st.DataObject) -> None:
    order = CubeOrder(cubes)
    one, *others = data.draw(st.lists(st.sampled_from(sorted(cubes)), min_size=1))
    union = 0
    for other in others:
        union |= int(order.letters(other))
    is_covered = any(other & one == other for other in others)
    assert (int(order.letters(one)) & ~union == 0) is is_covered


@given(st.sets(CUBES, min_size=1))
def test_of_a_set_the_weakest_cubes_are_named(cubes: set[Cube]) -> None:
    order = CubeOrder(cubes)
    union = order.letters(min(cubes))
    for cube in cubes:
        union |= order.letters(cube)
    weakest = {c for c in cubes if not any(c != d and d & c == d for d in cubes)}
    assert set(order.cubes(union)) == weakest


MIXTURES = (
    "cube & letters",
    "letters | cube",
    "cube << 1",
    "alphabet.letters(letters)",
    "plain(cube)",
)


@pytest.mark.long
@pytest.mark.slow
def test_the_type_checker_tells_cubes_from_sets_of_letters(tmp_path: Path) -> None:
    """It reads two files: with all that they import it took ten seconds and more."""
    program = tmp_path / "program.py"
    lines = [
        "from companion.ltl.labels import Alphabet, Cube, LetterSet",
        "def mixed(cube: Cube, letters: LetterSet, alphabet: Alphabet) -> None:",
        "    def plain(bits: int) -> int: return bits",
        "    print(cube | cube, letters & ~letters, alphabet.letters(cube), plain(int(cube)))",
        *(f"    {mixture}" for mixture in MIXTURES),
    ]
    program.write_text("\n".join(lines), encoding="utf-8")
    alone = ["--strict", "--follow-imports=skip", "--cache-dir", os.devnull]
    report, _, _ = mypy.run([*alone, str(program), labels.__file__])
    told = [line for line in report.splitlines() if ": error: " in line]
    assert [line.partition(": error")[0].rpartition("/")[2] for line in told] == [
        f"{program.name}:{number}" for number in range(5, 5 + len(MIXTURES))
    ], report
