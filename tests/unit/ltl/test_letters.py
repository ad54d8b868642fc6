"""Labels as sets of letters: what cubes read, back to cubes, and exclusive propositions."""

from __future__ import annotations

from itertools import product

from hypothesis import given
from hypothesis import strategies as st

from companion.ltl.automaton import Label
from companion.ltl.letters import MAX_LETTERS, Alphabet

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


def letters(alphabet: Alphabet) -> dict[int, frozenset[str]]:
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
        assert sum(letters(alphabet)) == alphabet.every


@given(LABELS, st.sampled_from([PLAIN, PLACES]))
def test_a_cube_reads_the_letters_that_its_label_matches(label: Label, alphabet: Alphabet) -> None:
    cube = alphabet.cube(label)
    assert alphabet.label(cube) == label
    matched = sum(bits for bits, held in letters(alphabet).items() if label.matches(held))
    assert alphabet.letters(cube) == matched


@given(st.data(), st.sampled_from([PLAIN, PLACES]))
def test_cubes_read_a_set_of_letters_without_overlap(
    data: st.DataObject, alphabet: Alphabet
) -> None:
    wanted = data.draw(st.integers(0, alphabet.every))
    parts = [alphabet.letters(cube) for cube in alphabet.cubes(wanted)]
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
