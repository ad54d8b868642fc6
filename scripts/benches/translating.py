"""The size of automata, and the time that it takes to make them.

The peer is Spot, with the figures that `ltl2tgba` had for the formulas of tests/data/formulas.tsv:
its state-based and its generalized transition-based automata.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from statistics import median, quantiles
from typing import NamedTuple

from benches import ROOT, Row, timed
from companion.ltl.automaton import BuchiAutomaton
from companion.ltl.formula import conjuncts
from companion.ltl.parser import parse
from companion.ltl.translate import state_based, translate

TABLE = ROOT / "tests" / "data" / "formulas.tsv"


class Entry(NamedTuple):
    """A formula of the table; states that Spot needs, None where it gave up."""

    group: str
    formula: str
    generalized: int | None
    by_states: int | None


def entries() -> list[Entry]:
    """The table without the paper's formula, which has rows of its own."""
    rows = [line.split("\t") for line in TABLE.read_text(encoding="utf-8").splitlines()]
    return [
        Entry(group, formula, *(int(n) if n.isdigit() else None for n in (generalized, by_states)))
        for group, _, formula, generalized, by_states, *_ in rows
        if group not in ("# group", "paper")
    ]


def tables(runs: int) -> Iterator[Row]:
    """States over the formulas that Spot solves, and milliseconds a formula."""
    ours: dict[str, list[int]] = defaultdict(lambda: [0, 0])
    spots: dict[str, list[int]] = defaultdict(lambda: [0, 0])
    passed = []
    for entry in entries()[:: 1 if runs >= 50 else 20]:
        made: list[BuchiAutomaton] = []

        def make(text: str = entry.formula, made: list[BuchiAutomaton] = made) -> None:
            made.append(translate(parse(text)))
            made.append(state_based(made[0]))

        passed += timed(make, 1)
        for kind, peer in enumerate((entry.generalized, entry.by_states)):
            if peer is not None:
                ours[entry.group][kind] += made[kind].states
                spots[entry.group][kind] += peer
    for group in ours:
        for kind, name in enumerate(("generalized", "state-based")):
            peer = spots[group][kind]
            yield Row(f"{group}, {name}", ours[group][kind], "states", "Spot", peer)
    yield Row("a formula, both kinds: median", median(passed), "ms")
    yield Row("95 % of them", quantiles(passed, n=20)[-1], "ms")
    yield Row("the slowest", max(passed), "ms")


def paper(runs: int) -> Iterator[Row]:
    """The paper's formula for n sites: as one automaton, with exclusive places, as conjuncts."""
    for sites, peer in ((3, 56), (5, 320)):
        states = state_based(translate(parse(search(sites)))).states
        yield Row(f"one automaton, {sites} sites", states, "states", "Spot", peer)
    sites = 10 if runs >= 50 else 4
    places = frozenset({*(f"p{i}" for i in range(sites)), "ph"})
    made: list[BuchiAutomaton] = []
    one = parse(search(sites))
    passed = timed(lambda: made.append(state_based(translate(one, exclusive=places))), 1)
    yield Row(f"one automaton, exclusive places, {sites} sites", made[0].states, "states")
    yield Row("made in", passed[0] / 1000, "s")
    many = parse(search(50))
    passed = timed(lambda: [translate(part) for part in conjuncts(many)], 1)
    yield Row("automata of the conjuncts, 50 sites", passed[0], "ms")


def search(sites: int) -> str:
    """The paper's formula (Section V) for some number of sites."""
    found = " & ".join(f"(F p{i} | ptf)" for i in range(sites))
    return f"G ({found}) & G ((ptf | ptr) -> F ptr) & G (ptr -> X ph)"
