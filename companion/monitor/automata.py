"""Follows the automata of the task along the recorded word, for drawing.

An automaton has its marks on transitions. To show them on states, as in textbooks, a node is a
state together with the marks of the transition that was just taken; a node with all marks is
accepting. The word is read from the `position` lines, as by an audit.

The vehicle is at one place at a time, which the automata may assume: a patrol of ten places then
has 15 transitions. Otherwise it would have 1,028, with a million labels among its nodes.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property

from companion.ltl.automaton import BuchiAutomaton, Label
from companion.ltl.formula import Formula, atoms
from companion.ltl.monitor import live_states
from companion.ltl.semantics import Letter
from companion.ltl.timed_formula import Line, parts
from companion.ltl.translate import translate
from companion.mission.facts import AT, Fact
from companion.monitor.obligations import Obligations
from companion.monitor.page_events import Arrow, AutomataMoved, AutomatonDrawing, Edge

Node = tuple[int, frozenset[int]]
"""A state, and the marks of the transition that led to it."""
Step = tuple[Node, Node]


@dataclass(frozen=True)
class DrawnAutomaton:
    """The automaton of one conjunct, with its marks on nodes."""

    name: str
    text: str
    automaton: BuchiAutomaton

    @cached_property
    def live(self) -> frozenset[int]:
        """States from which some word is accepted; the others are not drawn."""
        return live_states(self.automaton)

    @cached_property
    def start(self) -> frozenset[Node]:
        """The nodes in which runs begin, without marks."""
        return frozenset((state, frozenset()) for state in self.automaton.initial & self.live)

    @cached_property
    def nodes(self) -> tuple[Node, ...]:
        """All reachable nodes, in the order in which they are found."""
        found = sorted(self.start, key=_order)
        for state, _ in found:  # `found` grows in the loop
            ends = {(t.target, t.marks) for t in self.automaton.outgoing[state]}
            found += sorted((e for e in ends - set(found) if e[0] in self.live), key=_order)
        return tuple(found)

    @cached_property
    def number(self) -> dict[Node, int]:
        """The index of each node."""
        return {node: i for i, node in enumerate(self.nodes)}

    def steps(self, nodes: Collection[Node], letter: Letter) -> frozenset[Step]:
        """The steps with which a letter is read."""
        return frozenset(
            (node, (t.target, t.marks))
            for node in nodes
            for t in self.automaton.outgoing[node[0]]
            if t.target in self.live and t.label.matches(letter)
        )

    def after(self, nodes: Collection[Node], letter: Letter) -> frozenset[Node]:
        """The nodes after one letter."""
        return frozenset(end for _, end in self.steps(nodes, letter))

    @property
    def drawing(self) -> AutomatonDrawing:
        """Nodes (accepting or not), and labelled arrows between them."""
        number = self.number
        arrows: dict[Edge, list[Label]] = {}
        for node in self.nodes:
            for t in self.automaton.outgoing[node[0]]:
                end = (t.target, t.marks)
                if end in number:
                    arrows.setdefault((number[node], number[end]), []).append(t.label)
        return AutomatonDrawing(
            conjunct=self.name,
            formula=self.text,
            initial=tuple(sorted(number[node] for node in self.start)),
            accepting=tuple(len(marks) == self.automaton.marks for _, marks in self.nodes),
            arrows=tuple(Arrow(*ends, _told(labels)) for ends, labels in arrows.items()),
        )


def _told(labels: Sequence[Label]) -> str:
    """Cubes joined by `or`, without what one literal already implies for the others.

    >>> a, b = frozenset({"a"}), frozenset({"b"})
    >>> _told([Label(a, frozenset()), Label(b, a)])
    'a or b'
    """
    alone = [each for each in labels if len(each.positive) + len(each.negative) == 1]
    held = frozenset().union(*(each.positive for each in alone))
    absent = frozenset().union(*(each.negative for each in alone))
    less = [
        each if each in alone else Label(each.positive - absent, each.negative - held)
        for each in labels
    ]
    return " or ".join(dict.fromkeys(map(str, less)))


def _places(formula: Formula) -> frozenset[str]:
    """The propositions that say where the vehicle is."""
    return frozenset(atom for atom in atoms(formula) if Fact.parse(atom).predicate == AT)


def _order(node: Node) -> tuple[int, list[int]]:
    return (node[0], sorted(node[1]))


class TaskReader:
    """Reads the word of a flight with the automata of its task."""

    def __init__(self, task: dict[str, Line]) -> None:
        lines = [(name, part, bound) for name, line in task.items() for part, bound in parts(line)]
        self.automata = [
            DrawnAutomaton(name, str(bound or part), translate(part, exclusive=_places(part)))
            for name, part, bound in lines
        ]
        self.obligations = Obligations([(name, part) for name, part, _ in lines])
        self._nodes = [automaton.start for automaton in self.automata]
        self._steps: list[frozenset[Step]] = [frozenset() for _ in self.automata]

    def read(self, letter: Letter, restarted: Collection[str]) -> None:
        """Reads one more position; the named conjuncts restart with it."""
        self.obligations.read(letter, restarted)
        for i, automaton in enumerate(self.automata):
            before = automaton.start if automaton.name in restarted else self._nodes[i]
            self._steps[i] = automaton.steps(before, letter)
            self._nodes[i] = frozenset(end for _, end in self._steps[i])

    @property
    def moved(self) -> AutomataMoved:
        """The nodes in which the automata may be, how they came there, and what is due.

        An automaton without such a node is that of a violated conjunct.
        """
        numbers = [each.number for each in self.automata]
        return AutomataMoved(
            tuple(
                tuple(sorted(number[node] for node in nodes))
                for number, nodes in zip(numbers, self._nodes, strict=True)
            ),
            tuple(
                tuple(sorted((number[start], number[end]) for start, end in steps))
                for number, steps in zip(numbers, self._steps, strict=True)
            ),
            self.obligations.due,
        )
