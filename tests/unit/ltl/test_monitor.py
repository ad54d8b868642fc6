"""The three-valued monitor: each truth value against all continuations that can be tried.

That a truth value is not FALSE is shown by a continuation along the automaton, that it is FALSE by
thousands of words; both are judged by the semantics, without an automaton. TRUE is FALSE of the
negation.
"""

from __future__ import annotations

import random
from itertools import pairwise

import networkx as nx
import pytest
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st
from oracle import Sample, random_words, satisfying, small_words

from companion.ltl.automaton import BuchiAutomaton, Label, Transition
from companion.ltl.formula import Formula, Operator, negate
from companion.ltl.monitor import Monitor, Runs, TruthValue, live_states
from companion.ltl.parser import parse
from companion.ltl.semantics import Letter, accepts, holds

NAMES = ("p", "q")
UNARY = [Operator.NOT, Operator.NEXT, Operator.EVENTUALLY, Operator.ALWAYS]
BINARY = [Operator.UNTIL, Operator.RELEASE, Operator.WEAK_UNTIL, Operator.AND, Operator.OR]
FORMULAS = st.recursive(
    st.sampled_from([parse(name) for name in NAMES]),
    lambda inner: (
        st.builds(lambda op, f: Formula(op, (f,)), st.sampled_from(UNARY), inner)
        | st.builds(Formula, st.sampled_from(BINARY), st.tuples(inner, inner))
    ),
    max_leaves=4,
)
LETTERS = st.frozensets(st.sampled_from(NAMES))
HISTORIES = st.lists(LETTERS, max_size=4)
CONTINUATIONS = [
    (prefix[:4], loop)
    for prefix, loop in small_words(NAMES, 400) + random_words(NAMES, random.Random(1), 600)
]


def after(formula: Formula, letters: list[Letter]) -> Monitor:
    monitor = Monitor.of(formula)
    for letter in letters:
        monitor = monitor.after(letter)
    return monitor


def continuation(runs: Runs) -> tuple[list[Letter], list[Letter]]:
    """A word that is accepted from where some run is."""
    graph = nx.MultiDiGraph()
    graph.add_nodes_from(range(runs.automaton.states))
    for t in runs.automaton.transitions:
        graph.add_edge(t.source, t.target, t=t)

    def way(source: int, target: int) -> list[Transition]:
        nodes = nx.shortest_path(graph, source, target)
        return [next(iter(graph[a][b].values()))["t"] for a, b in pairwise(nodes)]

    for nodes in nx.strongly_connected_components(graph):
        inside = [t for t in runs.automaton.transitions if {t.source, t.target} <= nodes]
        with_mark = [[t for t in inside if m in t.marks] for m in marks(runs)]
        if not inside or not all(with_mark):
            continue
        chosen = [found[0] for found in with_mark] or inside[:1]
        for start in runs.states:
            if not nx.has_path(graph, start, chosen[0].source):
                continue
            loop: list[Transition] = []
            for t, following in zip(chosen, [*chosen[1:], chosen[0]], strict=True):
                loop += [t, *way(t.target, following.source)]
            prefix = way(start, chosen[0].source)
            return [t.label.positive for t in prefix], [t.label.positive for t in loop]
    raise AssertionError("nothing is accepted")


def marks(runs: Runs) -> range:
    return range(runs.automaton.marks)


@pytest.mark.slow
@drawn(150)
@given(FORMULAS, HISTORIES)
def test_false_iff_no_continuation_satisfies_and_true_iff_all_do(
    formula: Formula, letters: list[Letter]
) -> None:
    monitor = after(formula, letters)
    sample = Sample(((*letters, *prefix), loop) for prefix, loop in CONTINUATIONS)
    for asked, runs in ((formula, monitor.holding), (negate(formula), monitor.failing)):
        if runs.states:
            prefix, loop = continuation(runs)
            assert holds(asked, [*letters, *prefix], loop)
        else:
            assert satisfying(asked, sample) == 0
    assert (monitor.truth_value is TruthValue.FALSE) == (not monitor.holding.states)
    assert (monitor.truth_value is TruthValue.TRUE) == (not monitor.failing.states)


@given(FORMULAS, HISTORIES, LETTERS)
def test_true_and_false_stay(formula: Formula, letters: list[Letter], letter: Letter) -> None:
    monitor = after(formula, letters)
    if monitor.truth_value is not TruthValue.INCONCLUSIVE:
        assert monitor.after(letter).truth_value is monitor.truth_value


@pytest.mark.long
@pytest.mark.slow
@given(HISTORIES)
def test_what_is_to_happen_infinitely_often_stays_inconclusive(letters: list[Letter]) -> None:
    for formula in ("G F p", "F G p", "G (p -> F q)"):
        assert after(parse(formula), letters).truth_value is TruthValue.INCONCLUSIVE


@given(HISTORIES)
def test_safety_is_lost_and_a_goal_is_won_with_the_first_p(letters: list[Letter]) -> None:
    is_met = any("p" in letter for letter in letters)
    safety, goal = (after(parse(text), letters).truth_value for text in ("G !p", "F p"))
    assert safety is (TruthValue.FALSE if is_met else TruthValue.INCONCLUSIVE)
    assert goal is (TruthValue.TRUE if is_met else TruthValue.INCONCLUSIVE)


@pytest.mark.parametrize(
    ("formula", "value"),
    [("p | !p", TruthValue.TRUE), ("F p & G !p", TruthValue.FALSE), ("X X true", TruthValue.TRUE)],
)
def test_what_needs_no_letter_is_known_at_once(formula: str, value: TruthValue) -> None:
    assert Monitor.of(parse(formula)).truth_value is value


@pytest.mark.parametrize(("source", "goal"), [("at(A)", "at(B)"), ("at(B)", "at(A)")])
def test_next_is_decided_two_positions_later(source: str, goal: str) -> None:
    monitor = after(parse(f"G ({source} -> X {goal})"), [frozenset({source})])
    assert monitor.truth_value is TruthValue.INCONCLUSIVE
    assert monitor.after(frozenset({goal})).truth_value is TruthValue.INCONCLUSIVE
    assert monitor.after(frozenset()).truth_value is TruthValue.FALSE


TRUE_LABEL = Label(frozenset(), frozenset())
NEVER = Label(frozenset({"p"}), frozenset({"p"}))


def automaton(*edges: tuple[int, int, set[int]], marks: int, label: Label) -> BuchiAutomaton:
    transitions = tuple(Transition(s, label, t, frozenset(m)) for s, t, m in edges)
    states = 1 + max(max(s, t) for s, t, _ in edges)
    return BuchiAutomaton(states, frozenset({0}), transitions, marks)


def test_a_state_is_live_if_a_run_from_it_can_meet_every_mark_again_and_again() -> None:
    """0 -> 1 <-> 2 with both marks on the circle; 3 has but one mark; 4 leads nowhere."""
    edges: list[tuple[int, int, set[int]]] = [
        (0, 1, set()), (1, 2, {0}), (2, 1, {1}), (0, 3, {0, 1}), (3, 3, {0}), (3, 4, {1}),
    ]  # fmt: skip
    asked = automaton(*edges, marks=2, label=TRUE_LABEL)
    assert live_states(asked) == {0, 1, 2}
    for state in range(5):
        begun = BuchiAutomaton(5, frozenset({state}), asked.transitions, 2)
        assert accepts(begun, [], [frozenset()]) is (state in live_states(asked))


def test_a_label_that_no_letter_matches_keeps_no_state_live() -> None:
    assert live_states(automaton((0, 0, {0}), marks=1, label=NEVER)) == frozenset()
