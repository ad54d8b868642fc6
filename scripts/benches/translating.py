"""The size of automata, and the time that it takes to make them.

The peer is Spot in the same run: the automata of `ltl2tgba`, with marks on edges and on states. The
extra `test` installs it where it has a wheel (Linux on x86-64); without it there is no peer.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from functools import partial
from statistics import median, quantiles

from benches import ROOT, Row, spot_peer, timed
from companion.ltl.automaton import BuchiAutomaton
from companion.ltl.conjuncts import conjuncts
from companion.ltl.formula import Formula
from companion.ltl.parser import parse
from companion.ltl.translate import state_based, translate

TABLE = ROOT / "tests" / "data" / "formulas.tsv"


def formulas() -> list[tuple[str, str]]:
    """Group and text of each formula, except the paper's, which has its own rows."""
    rows = [line.split("\t") for line in TABLE.read_text(encoding="utf-8").splitlines()]
    return [(group, text) for group, _, text, *_ in rows if group not in ("# group", "paper")]


def edges(automaton: BuchiAutomaton) -> int:
    """The number of edges if labels may be any formula, like Spot's."""
    return len({(t.source, t.target, t.marks) for t in automaton.transitions})


Totals = dict[tuple[str, str, str], int]
"""Group, kind of automaton and unit -> sum."""


def tables(runs: int) -> Iterator[Row]:
    """States and edges of all formulas of a group, and milliseconds per formula."""
    ours: Totals = defaultdict(int)
    peers: Totals = defaultdict(int)
    passed, peer_passed = [], []
    for group, text in formulas()[:: 1 if runs >= 50 else 20]:
        formula = parse(text)
        made: list[BuchiAutomaton] = []

        def make(formula: Formula = formula, made: list[BuchiAutomaton] = made) -> None:
            made.append(translate(formula))
            made.append(state_based(made[0]))

        passed += timed(make, 1)
        for kind, automaton in zip(spot_peer.KINDS, made, strict=True):
            ours[group, kind, "states"] += automaton.states
            ours[group, kind, "edges"] += edges(automaton)
        if spot_peer.NAME is not None:
            peer_passed += timed(partial(spot_peer.automata, formula), 1)
            for kind, (states, count) in spot_peer.sizes(formula).items():
                peers[group, kind, "states"] += states
                peers[group, kind, "edges"] += count
    for (group, kind, unit), figure in ours.items():
        peer_figure = peers.get((group, kind, unit))
        yield Row(f"{group}, {kind}: {unit}", figure, unit, spot_peer.NAME, peer_figure)
    for name, summary in (
        ("a formula, both kinds: median", median),
        ("95 % of them", lambda times: quantiles(times, n=20)[-1]),
        ("the slowest", max),
    ):
        peer_ms = summary(peer_passed) if peer_passed else None
        yield Row(name, summary(passed), "ms", spot_peer.NAME, peer_ms)


def paper(runs: int) -> Iterator[Row]:
    """The paper's formula for n sites: as one automaton, with exclusive places, as conjuncts."""
    for sites in (3, 5) if runs >= 50 else (2, 3):
        formula = parse(search(sites))
        states = state_based(translate(formula)).states
        peer = spot_peer.sizes(formula)["state-based"][0] if spot_peer.NAME else None
        yield Row(f"one automaton, {sites} sites", states, "states", spot_peer.NAME, peer)
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
    """The paper's formula (Section V) for a number of sites."""
    found = " & ".join(f"(F p{i} | ptf)" for i in range(sites))
    return f"G ({found}) & G ((ptf | ptr) -> F ptr) & G (ptr -> X ph)"
