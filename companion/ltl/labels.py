"""The labels of edges under construction: cubes and sets of letters.

A *letter* is the set of propositions that hold at one position. A label says which letters an edge
reads, in one of two forms:

- a *cube* is a conjunction of literals, with two bits for each proposition: p, !p. Cubes are small
  for any number of propositions, but not closed under union and difference;
- a *set of letters* has a bit for each letter. It can express the union and the difference of what
  two edges read, but its size doubles with each proposition.

An `Alphabet` converts one form into the other. At most one of the *exclusive* propositions holds at
a time (a vehicle is at one place); letters with two of them do not exist, so 50 places make 51
letters.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING, TypeVar

from companion.ltl.automaton import Label
from companion.ltl.bitsets import indices

MAX_LETTERS = 4096
"""The most letters for which sets of letters are used: ints of 512 bytes."""

if TYPE_CHECKING:

    class Cube:
        """A conjunction of literals: bit 2 i for proposition i, bit 2 i + 1 for its negation.

        `a | b` has the literals of both cubes, so it reads what both of them read. `a & b` has the
        literals that they share. `a & b == a` means that `a` reads all that `b` reads.
        """

        def __init__(self, literals: int = 0) -> None: ...
        def __or__(self, other: Cube) -> Cube: ...
        def __and__(self, other: Cube) -> Cube: ...
        def __invert__(self) -> Cube: ...
        def __lt__(self, other: Cube) -> bool: ...
        def __int__(self) -> int: ...

    class LetterSet:
        """A set of letters, one bit each, with union, intersection and complement.

        `~a` is an infinite set; use it as in `b & ~a`, the difference.
        """

        def __init__(self, letters: int = 0) -> None: ...
        def __or__(self, other: LetterSet) -> LetterSet: ...
        def __and__(self, other: LetterSet) -> LetterSet: ...
        def __invert__(self) -> LetterSet: ...
        def __bool__(self) -> bool: ...
        def __int__(self) -> int: ...

        def bit_count(self) -> int:
            """The number of letters."""

        def bit_length(self) -> int:
            """One more than the highest number of a letter."""

else:
    # At run time both are ints, whose operations are what all reductions spend their time on. For
    # the type checker they are distinct classes with only the operations above.
    Cube = LetterSet = int

L = TypeVar("L", bound=Cube | LetterSet)
"""The kind of labels that a graph has."""


class Alphabet:
    """The letters over some propositions; proposition number i has bits 2 i and 2 i + 1 of a cube.

    >>> alphabet = Alphabet(["p", "q"])
    >>> p = alphabet.cube(Label(frozenset({"p"}), frozenset()))
    >>> q = alphabet.cube(Label(frozenset({"q"}), frozenset()))
    >>> either = alphabet.letters(p) | alphabet.letters(q)
    >>> [str(alphabet.label(cube)) for cube in alphabet.cubes(either)]
    ['p', '!p & q']
    """

    def __init__(self, names: Sequence[str], exclusive: frozenset[str] = frozenset()) -> None:
        self.names = tuple(names)
        self.exclusive = exclusive.intersection(names)
        self._bit_of = {name: 1 << 2 * i for i, name in enumerate(names)}
        self._size = (len(self.exclusive) + 1) << (len(self.names) - len(self.exclusive))
        self._letters_of: dict[Cube, LetterSet] = {}
        self._cube_of: dict[LetterSet, Cube] = {}

    @property
    def is_small(self) -> bool:
        """Whether labels can be sets of letters."""
        return self._size <= MAX_LETTERS

    @cached_property
    def every(self) -> LetterSet:
        """The set of all letters."""
        return LetterSet((1 << self._size) - 1)

    @cached_property
    def _literals(self) -> list[LetterSet]:
        """The letters of each literal: p, !p, q, !q, ...

        With f propositions that are not exclusive, letters come in blocks of 2^f: in block 0 no
        exclusive proposition holds, in block i the i-th one.
        """
        places = [i for i, name in enumerate(self.names) if name in self.exclusive]
        free = [i for i, name in enumerate(self.names) if name not in self.exclusive]
        block = 1 << len(free)
        positive = [LetterSet(0)] * len(self.names)
        for number, i in enumerate(places, 1):
            positive[i] = LetterSet(((1 << block) - 1) << block * number)
        for number, i in enumerate(free):
            period = 2 << number
            pattern = ((1 << period // 2) - 1) << period // 2
            while period < self._size:
                pattern |= pattern << period
                period *= 2
            positive[i] = LetterSet(pattern) & self.every
        return [side for letters in positive for side in (letters, self.every & ~letters)]

    def letters(self, cube: Cube) -> LetterSet:
        """The letters that a cube reads."""
        if cube not in self._letters_of:
            found = self.every
            for i in indices(int(cube)):
                found &= self._literals[i]
            self._letters_of[cube] = found
            self._cube_of[found] = cube
        return self._letters_of[cube]

    def cubes(self, letters: LetterSet) -> list[Cube]:
        """Disjoint cubes that together read exactly these letters."""
        found = []
        while letters:
            cube = self._cube_of.get(letters)
            if cube is None:
                ends = (lowest_letter(letters), highest_letter(letters))
                cube = max((self._widened(letter, letters) for letter in ends), key=self._reads)
            found.append(cube)
            letters &= ~self.letters(cube)
        return found

    def _reads(self, cube: Cube) -> int:
        return self.letters(cube).bit_count()

    def _widened(self, letter: LetterSet, within: LetterSet) -> Cube:
        """The largest cube that contains a letter and reads only letters of the set."""
        literals = [i for i, letters in enumerate(self._literals) if letters & letter]
        left = [self.every]  # what literals read together: none, the last, the last two, ...
        for i in reversed(literals):
            left.append(left[-1] & self._literals[i])
        cube, read = Cube(0), self.every
        for i in literals:
            left.pop()
            if read & left[-1] & ~within:
                cube |= Cube(1 << i)
                read &= self._literals[i]
        return cube

    def cube(self, label: Label) -> Cube:
        """Converts a label to a cube."""
        bit_of = self._bit_of
        positive = sum([bit_of[name] for name in label.positive if name in bit_of])
        negative = sum([bit_of[name] for name in label.negative if name in bit_of])
        return Cube(positive | negative << 1)

    def label(self, cube: Cube) -> Label:
        """Converts a cube to a label."""
        literals = [divmod(i, 2) for i in indices(int(cube))]
        positive, negative = (
            frozenset(self.names[number] for number, is_negated in literals if is_negated == sign)
            for sign in (0, 1)
        )
        return Label(positive, negative)


class CubeOrder:
    """Treats cubes as sets of letters, where each letter is one of the given cubes.

    A cube stands for all given cubes that have its literals. So a union of such sets includes
    another set only if a single member of the union does: edges are compared one by one.

    >>> p, p_and_q = Cube(0b0001), Cube(0b0101)
    >>> order = CubeOrder([p, p_and_q])
    >>> bin(order.letters(p)), bin(order.letters(p_and_q))
    ('0b11', '0b10')
    >>> order.cubes(order.letters(p) | order.letters(p_and_q)) == [p]
    True
    """

    def __init__(self, cubes: Iterable[Cube]) -> None:
        self._cubes = sorted(set(cubes), key=lambda cube: int(cube).bit_count())
        with_literal: dict[int, LetterSet] = defaultdict(LetterSet)
        for number, cube in enumerate(self._cubes):
            for i in indices(int(cube)):
                with_literal[i] |= LetterSet(1 << number)
        every = LetterSet((1 << len(self._cubes)) - 1)
        self._letters_of: dict[Cube, LetterSet] = {}
        for cube in self._cubes:
            found = every
            for i in indices(int(cube)):
                found &= with_literal[i]
            self._letters_of[cube] = found

    @property
    def width(self) -> int:
        """Number of bits of a set."""
        return len(self._cubes)

    def letters(self, cube: Cube) -> LetterSet:
        """The given cubes that have all literals of this cube."""
        return self._letters_of[cube]

    def cubes(self, letters: LetterSet) -> list[Cube]:
        """The weakest cubes in a set: no literal can be left out of them."""
        found = []
        while letters:
            found.append(self._cubes[lowest_letter(letters).bit_length() - 1])
            letters &= ~self._letters_of[found[-1]]
        return found


def lowest_letter(letters: LetterSet) -> LetterSet:
    """One letter of a nonempty set, as a set."""
    bits = int(letters)
    return LetterSet(bits & -bits)


def highest_letter(letters: LetterSet) -> LetterSet:
    """One letter of a nonempty set, as a set; not `lowest_letter` if there are several."""
    return LetterSet(1 << letters.bit_length() - 1)


def opposite(literal: Cube) -> Cube:
    """The negation of a cube that has one literal.

    >>> bin(opposite(Cube(0b100))), bin(opposite(Cube(0b1000)))
    ('0b1000', '0b100')
    """
    bit = int(literal)
    return Cube(bit >> 1 if bit.bit_length() % 2 == 0 else bit << 1)


def joined(cubes: Iterable[Cube]) -> list[Cube]:
    """Fewer cubes that read the same letters: a & p and a & !p become a.

    >>> a_and_p, a_and_not_p = Cube(0b0101), Cube(0b1001)
    >>> [bin(cube) for cube in joined([a_and_p, a_and_not_p])]
    ['0b1']
    """
    left = set(cubes)
    for one, other in combinations(sorted(left), 2):
        differ = int(one) ^ int(other)
        low = differ & -differ
        is_pair = differ == 3 * low and low.bit_length() % 2 == 1
        if is_pair and (int(one) & differ).bit_count() == 1 == (int(other) & differ).bit_count():
            return joined((left - {one, other}) | {one & other})
    return sorted(left)
