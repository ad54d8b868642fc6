"""A three-valued monitor (LTL3): what finitely many letters tell about a formula.

1. A formula is TRUE if every continuation satisfies it, FALSE if none does, and INCONCLUSIVE
   otherwise.
2. It is FALSE once its automaton has no run left in a state from which some word is accepted. It is
   TRUE once the automaton of its negation has none.
3. TRUE and FALSE are final. `G F p` is always INCONCLUSIVE: no finite word decides what happens
   infinitely often.

A continuation may contain any letters, even those that no skill can produce. Whether the vehicle
can still do its task is a question for the planner.

Source: Bauer, Leucker and Schallhart, Runtime verification for LTL and TLTL, ACM TOSEM 2011.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum

from companion.ltl.automaton import BuchiAutomaton, Transition, successors
from companion.ltl.budget import Budget
from companion.ltl.components import reaching, strong_components
from companion.ltl.formula import Formula, negate
from companion.ltl.semantics import Letter
from companion.ltl.translate import translate


class TruthValue(Enum):
    """Truth values of LTL3; INCONCLUSIVE is written `?` in the literature."""

    TRUE = "true"
    FALSE = "false"
    INCONCLUSIVE = "open"


@dataclass(frozen=True, slots=True)
class Runs:
    """The runs of an automaton that can still accept.

    Attributes:
        automaton: the automaton that reads the word.
        live: its states from which some word is accepted.
        states: the live states that the runs are in.
    """

    automaton: BuchiAutomaton
    live: frozenset[int]
    states: frozenset[int]

    @classmethod
    def begin(cls, automaton: BuchiAutomaton) -> Runs:
        """The runs before the first letter."""
        live = live_states(automaton)
        return cls(automaton, live, automaton.initial & live)

    def after(self, letter: Letter) -> Runs:
        """The runs one letter later."""
        states = successors(self.automaton, self.states, letter) & self.live
        return replace(self, states=states)

    def marks_met(self, letter: Letter) -> frozenset[int]:
        """The acceptance marks that one of the runs meets when it reads the next letter."""
        taken = (t for state in self.states for t in self.automaton.outgoing[state])
        met = (t.marks for t in taken if t.target in self.live and t.label.matches(letter))
        return frozenset().union(*met)


@dataclass(frozen=True, slots=True)
class Monitor:
    """A formula after some letters; immutable.

    >>> from companion.ltl.parser import parse
    >>> monitor = Monitor.of(parse("!q U p"))
    >>> q, p = frozenset({"q"}), frozenset({"p"})
    >>> [m.truth_value.value for m in (monitor, monitor.after(p), monitor.after(q).after(p))]
    ['open', 'true', 'false']

    Attributes:
        holding: the runs of the formula's automaton.
        failing: the runs of the automaton of its negation.
    """

    holding: Runs
    failing: Runs

    @classmethod
    def of(cls, formula: Formula) -> Monitor:
        """The monitor before the first letter.

        Raises:
            TranslationLimit: one of the two automata would be too large.
        """
        budget = Budget()
        automata = [translate(f, budget=budget) for f in (formula, negate(formula))]
        return cls(*map(Runs.begin, automata))

    def after(self, letter: Letter) -> Monitor:
        """The monitor one letter later."""
        return Monitor(self.holding.after(letter), self.failing.after(letter))

    @property
    def truth_value(self) -> TruthValue:
        """The truth value after the letters so far."""
        if not self.holding.states:
            return TruthValue.FALSE
        return TruthValue.INCONCLUSIVE if self.failing.states else TruthValue.TRUE


def live_states(automaton: BuchiAutomaton) -> frozenset[int]:
    """The states from which some word is accepted.

    From them a run can reach a component in which it can meet every mark again and again.
    """
    edges = [[t for t in leaving if _can_read(t)] for leaving in automaton.outgoing]
    successors = [[t.target for t in leaving] for leaving in edges]
    components = strong_components(successors)
    every_mark = frozenset(range(automaton.marks))
    accepting = []
    for component in components:
        members = set(component)
        inside = [t.marks for state in component for t in edges[state] if t.target in members]
        accepting.append(bool(inside) and every_mark <= frozenset().union(*inside))
    return frozenset(reaching(successors, components, accepting))


def _can_read(transition: Transition) -> bool:
    """Whether some letter matches the label."""
    return transition.label.positive.isdisjoint(transition.label.negative)
