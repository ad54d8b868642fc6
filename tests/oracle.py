"""The words that a formula, or an automaton, accepts, of many: a second opinion, for tests.

Shares no code with `companion/ltl/semantics.py`, and works the other way round: there one word
is packed into an int, here one int holds the verdicts of all words at one position (bit w is
word w), so that thousands of words cost as much as one.

All words of a sample have the shape u v v v ... with the same lengths of u and v; words of other
shapes are unrolled to it. LOOP has many divisors, so no small loop is left out but those of
length 5.

Source: Baier and Katoen, Principles of Model Checking, Definition 5.6; Emerson and Lei,
Modalities for model checking, 1985, for acceptance as a nested fixpoint.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Sequence
from functools import cached_property, reduce
from itertools import count, product
from operator import and_, or_

from companion.ltl.automaton import BuchiAutomaton, Label
from companion.ltl.formula import Formula, Operator, atoms, subformulas

Letter = frozenset[str]
Lasso = tuple[tuple[Letter, ...], tuple[Letter, ...]]
"""The word u v v v ... as (u, v)."""

PREFIX, LOOP = 8, 12
LOOPS = (1, 2, 3, 4, 6, 12)
"""Lengths of loops that can be unrolled to LOOP."""


class Sample:
    """Lasso words side by side."""

    def __init__(self, words: Iterable[Lasso]) -> None:
        self.words = list(dict.fromkeys(words))
        self.everyone = (1 << len(self.words)) - 1
        self._where: dict[str, list[int]] = {}

    @cached_property
    def _letters(self) -> list[tuple[Letter, ...]]:
        """The letters of all words at each position, the last word first."""
        return list(zip(*map(_unrolled, reversed(self.words)), strict=True))

    def proposition(self, name: str) -> list[int]:
        """The words in which a proposition holds, by position."""
        if name not in self._where:
            self._where[name] = [
                int("".join(["1" if name in letter else "0" for letter in column]), 2)
                for column in self._letters
            ]
        return self._where[name]

    def chosen(self, words: int) -> list[Lasso]:
        """The words of a set of bits."""
        return [word for i, word in enumerate(self.words) if words >> i & 1]


def _unrolled(word: Lasso) -> list[Letter]:
    """The letters at the first PREFIX + LOOP positions, the last LOOP of which repeat."""
    prefix, loop = word
    if len(prefix) > PREFIX or len(loop) not in LOOPS:
        raise ValueError(f"{len(prefix)}, {len(loop)} positions are not a shape for samples")
    rest = PREFIX + LOOP - len(prefix)
    return [*prefix, *(loop * rest)[:rest]]


def satisfying(formula: Formula, sample: Sample) -> int:
    """The words (bits) that satisfy a formula at their first position."""
    rows: dict[Formula, list[int]] = {}
    for node in subformulas(formula):
        rows[node] = _row(node, [rows[operand] for operand in node.operands], sample)
    return rows[formula][0]


def _row(node: Formula, operands: list[list[int]], sample: Sample) -> list[int]:
    """The words that satisfy a node at each position, given those of its operands."""
    all_words = sample.everyone
    everywhere, nowhere = [all_words] * (PREFIX + LOOP), [0] * (PREFIX + LOOP)
    match node.operator:
        case Operator.TRUE:
            return everywhere
        case Operator.FALSE:
            return nowhere
        case Operator.ATOM:
            return sample.proposition(node.atom)
        case Operator.NOT:
            return [all_words ^ x for x in operands[0]]
        case Operator.AND:
            return [reduce(and_, column) for column in zip(*operands, strict=True)]
        case Operator.OR:
            return [reduce(or_, column) for column in zip(*operands, strict=True)]
        case Operator.IMPLIES:
            return [(all_words ^ x) | y for x, y in zip(*operands, strict=True)]
        case Operator.IFF:
            return [all_words ^ x ^ y for x, y in zip(*operands, strict=True)]
        case Operator.NEXT:
            return [*operands[0][1:], operands[0][PREFIX]]
        case Operator.EVENTUALLY:
            return _until(everywhere, operands[0], 0)
        case Operator.ALWAYS:
            return _until(operands[0], nowhere, all_words)
        case Operator.UNTIL:
            return _until(operands[0], operands[1], 0)
        case Operator.WEAK_UNTIL:
            return _until(operands[0], operands[1], all_words)
        case Operator.RELEASE:
            event, kept = operands
            both = [x & y for x, y in zip(event, kept, strict=True)]
            return _until(kept, both, all_words)


def _until(before: list[int], event: list[int], without_event: int) -> list[int]:
    """At each position: the event now, or `before` now and the same at the next position.

    Args:
        without_event: the verdict if `before` holds for ever and the event never comes.
    """
    row = [0] * (PREFIX + LOOP)
    later = without_event
    for _ in range(2):  # once round the loop to see all of it, once more to write it down
        for position in reversed(range(PREFIX, PREFIX + LOOP)):
            later = row[position] = event[position] | before[position] & later
    for position in reversed(range(PREFIX)):
        later = row[position] = event[position] | before[position] & later
    return row


def accepted(automaton: BuchiAutomaton, sample: Sample) -> int:
    """The words (bits) that an automaton accepts.

    A node is a state at a position of the loop. The good nodes of a word are the largest set
    from each of whose nodes a run meets one mark after the other and then a good node again.
    """
    readers: dict[Label, list[int]] = {}
    for label in {transition.label for transition in automaton.transitions}:
        readers[label] = _readers(label, sample)
    edges = [
        [(t.target, t.marks, readers[t.label]) for t in leaving] for leaving in automaton.outgoing
    ]
    good = [[sample.everyone] * LOOP for _ in range(automaton.states)]
    while True:
        better = good
        for mark in range(automaton.marks) or [None]:
            better = _reaching(edges, better, mark)
        if better == good:
            break
        good = better
    rows = [row[0] for row in good]
    for position in reversed(range(PREFIX)):
        rows = [
            reduce(or_, (read[position] & rows[target] for target, _, read in leaving), 0)
            for leaving in edges
        ]
    return reduce(or_, (rows[state] for state in automaton.initial), 0)


_Edges = list[list[tuple[int, frozenset[int], list[int]]]]
"""For each state: target, marks, and by position the words that the transition can read."""


def _reaching(edges: _Edges, good: list[list[int]], mark: int | None) -> list[list[int]]:
    """Nodes with a way to an edge that has a mark, or any if it is None, and a good target."""
    found = [[0] * LOOP for _ in edges]
    is_changed = True
    while is_changed:
        is_changed = False
        for position in reversed(range(LOOP)):
            after = (position + 1) % LOOP
            for state, leaving in enumerate(edges):
                words = found[state][position]
                for target, marks, read in leaving:
                    reached = found[target][after]
                    if mark is None or mark in marks:
                        reached |= good[target][after]
                    words |= read[PREFIX + position] & reached
                if words != found[state][position]:
                    found[state][position] = words
                    is_changed = True
    return found


def _readers(label: Label, sample: Sample) -> list[int]:
    """The words that a transition with a label can read, by position."""
    rows = [[sample.everyone] * (PREFIX + LOOP)]
    rows += [sample.proposition(name) for name in label.positive]
    rows += [[sample.everyone ^ x for x in sample.proposition(name)] for name in label.negative]
    return [reduce(and_, column) for column in zip(*rows, strict=True)]


SMALL, RANDOM, WALKS, NEIGHBOURS = 500, 100, 300, 800
"""How many words a sample has of each kind; small ones: at most."""


def words_for(
    formula: Formula, automata: Iterable[BuchiAutomaton], rng: random.Random, effort: int = 1
) -> Sample:
    """Words that a formula and automata are likely to disagree on, if they do on any.

    All small ones, random ones, words along the edges of the automata, and neighbours of those
    whose verdict is the rarer one.

    Args:
        effort: how many times as many words as usual.
    """
    names = sorted(atoms(formula)) or ["p"]
    words = small_words(names, effort * SMALL) + random_words(names, rng, effort * RANDOM)
    for automaton in automata:
        words += walks(automaton, names, rng, effort * WALKS)
    for _ in range(2):  # neighbours of neighbours as well
        sample = Sample(words)
        satisfied = satisfying(formula, sample)
        rarer = min(satisfied, sample.everyone ^ satisfied, key=int.bit_count)
        origins = sample.chosen(rarer or sample.everyone)
        words += [neighbour(rng.choice(origins), names, rng) for _ in range(effort * NEIGHBOURS)]
    return Sample(words)


def small_words(names: Sequence[str], limit: int) -> list[Lasso]:
    """All words of few positions over some propositions, as long as there are not too many."""
    if 2 ** len(names) > limit:
        return []
    letters = [
        frozenset(name for name, is_in in zip(names, choice, strict=True) if is_in)
        for choice in product((False, True), repeat=len(names))
    ]
    found: list[Lasso] = []
    for length in count(1):
        shapes = [n for n in LOOPS if length - PREFIX <= n <= length]
        if len(found) + len(shapes) * len(letters) ** length > limit:
            return found
        for loop in shapes:
            for word in product(letters, repeat=length):
                found.append((word[: length - loop], word[length - loop :]))
    raise AssertionError


def random_words(names: Sequence[str], rng: random.Random, number: int) -> list[Lasso]:
    """Words of all shapes; some have many propositions at a position and some few."""
    found = []
    for _ in range(number):
        density = rng.random() ** 2
        prefix, loop = rng.randrange(PREFIX + 1), rng.choice(LOOPS)
        word = [
            frozenset(name for name in names if rng.random() < density)
            for _ in range(prefix + loop)
        ]
        found.append((tuple(word[:prefix]), tuple(word[prefix:])))
    return found


def walks(
    automaton: BuchiAutomaton, names: Sequence[str], rng: random.Random, number: int
) -> list[Lasso]:
    """Words along random edges, each with a loop that leads back to a state.

    A walk that does not come back in time gives no word.
    """
    found = []
    for _ in range(number):
        density, patience = max(0.0, 2 * rng.random() - 1) ** 2, rng.random()
        states = [rng.choice(sorted(automaton.initial))]
        word: list[Letter] = []
        while len(word) < PREFIX + LOOP and automaton.outgoing[states[-1]]:
            leaving = automaton.outgoing[states[-1]]
            onward = [t for t in leaving if t.target not in states]
            step = rng.choice(onward if onward and rng.random() < 0.5 else leaving)
            noise = frozenset(name for name in names if rng.random() < density)
            word.append((noise | step.label.positive) - step.label.negative)
            states.append(step.target)
            starts = [
                start
                for start, state in enumerate(states[:-1])
                if state == step.target and start <= PREFIX and len(word) - start in LOOPS
            ]
            if starts and rng.random() > patience:
                start = rng.choice(starts)
                found.append((tuple(word[:start]), tuple(word[start:])))
                break
    return found


def neighbour(word: Lasso, names: Sequence[str], rng: random.Random) -> Lasso:
    """A word that differs in one proposition at one position."""
    prefix, loop = word
    letters = [*prefix, *loop]
    letters[rng.randrange(len(letters))] ^= {rng.choice(names)}
    return tuple(letters[: len(prefix)]), tuple(letters[len(prefix) :])
