"""What is still due, in words: what the task demands of the rest of the flight.

1. Goals that recur for ever (`G F p`) are due once per lap. A lap is over when each of them has
   been met; the next one begins with the following position.
2. What other lines demand is what formula progression leaves of them
   (`companion/ltl/progression.py`).
3. What must always hold, such as `G !at(D)`, is a rule and never due.
4. Lines that plans do not keep are not due, and do not belong to laps.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from itertools import groupby

from companion.ltl.conjuncts import conjuncts
from companion.ltl.formula import FALSE, TEMPORAL, TRUE, Formula, Operator, subformulas
from companion.ltl.progression import progressed
from companion.ltl.semantics import Letter
from companion.mission.facts import AT, Fact

MOST_TOLD, MOST_KEPT = 60, 1000
"""Most nodes of the rest of a line that are shown; and that are kept."""


class DueLine:
    """A conjunct of the task with what is left of it."""

    def __init__(self, name: str, formula: Formula) -> None:
        self.name = name
        self.is_dropped = False
        self.formula = self.rest = formula
        self.goals, self.otherwise = _recurring(formula)
        self.met: set[Formula] = set()

    @property
    def is_met(self) -> bool:
        """Whether each recurring goal has been met in this lap, or is not demanded any more."""
        return self.rest is TRUE or self.met.issuperset(self.goals)

    def read(self, letter: Letter, is_restarted: bool) -> None:
        """Reads one more position; a line that restarts with it has met nothing before."""
        if is_restarted:
            self.rest, self.met = self.formula, set()
        rest = progressed(self.rest, letter)
        self.rest = rest if _size(rest) <= MOST_KEPT else TRUE
        self.met |= {goal for goal in self.goals if progressed(goal, letter) is TRUE}

    @property
    def left(self) -> list[Formula]:
        """The recurring goals that are due in this lap."""
        return [] if self.is_met else [goal for goal in self.goals if goal not in self.met]

    @property
    def words(self) -> list[str]:
        """What is due of a line without recurring goals, in words."""
        if _size(self.rest) > MOST_TOLD:
            return []
        left_over = [each for each in conjuncts(self.rest) if each.operator is not Operator.ALWAYS]
        return [
            f"{in_words(each)} {'still due' if _is_temporal(each) else 'due at the next position'}"
            for each in left_over
            if each not in (TRUE, FALSE)
        ]


def _recurring(formula: Formula) -> tuple[tuple[Formula, ...], tuple[Formula, ...]]:
    """The goals that must hold again and again, and what may be done instead.

    None if the line is not `G F p & ...`, or that `|` something else.
    """
    choices = formula.operands if formula.operator is Operator.OR else (formula,)
    for choice in choices:
        goals = [_goal(part) for part in conjuncts(choice)]
        if TRUE not in goals:
            return tuple(goals), tuple(each for each in choices if each is not choice)
    return (), ()


def _goal(part: Formula) -> Formula:
    """p of `G F p`; true for all others."""
    inner = part.operands[0] if part.operator is Operator.ALWAYS else TRUE
    goal = inner.operands[0] if inner.operator is Operator.EVENTUALLY else TRUE
    return TRUE if _is_temporal(goal) else goal


class Obligations:
    """Reads the word of a flight and says what is due."""

    def __init__(self, lines: Sequence[tuple[str, Formula]]) -> None:
        self.lines = [DueLine(name, formula) for name, formula in lines]

    def read(self, letter: Letter, restarted: Collection[str]) -> None:
        """Reads one more position; the named lines restart with it."""
        recurring = [each for each in self.lines if each.goals and not each.is_dropped]
        if all(each.is_met for each in recurring):
            for each in recurring:
                each.met.clear()
        for each in self.lines:
            each.read(letter, each.name in restarted)

    def drop(self, name: str, is_dropped: bool) -> None:
        """Notes whether plans keep a line."""
        for each in self.lines:
            if each.name == name:
                each.is_dropped = is_dropped

    @property
    def due(self) -> tuple[tuple[str, str], ...]:
        """The name of each line and what is due of it, in words; goals of a line together."""
        kept = (each for each in self.lines if not each.is_dropped)
        kinds = groupby(kept, key=lambda each: (each.name, bool(each.goals), each.otherwise))
        return tuple(
            (name, text)
            for (name, recurs, otherwise), alike in kinds
            for text in (
                _due_in_lap([goal for each in alike for goal in each.left], otherwise)
                if recurs
                else [text for each in alike for text in each.words]
            )
        )


def _due_in_lap(goals: Sequence[Formula], otherwise: Sequence[Formula]) -> list[str]:
    """What is due of the recurring goals of a line, in words."""
    left = ", ".join(map(in_words, goals))
    instead = "".join(f", or {in_words(each)}" for each in otherwise)
    return [f"{left} still due in this lap{instead}"] if goals else []


def in_words(formula: Formula) -> str:
    """What a formula demands, in plain words.

    >>> from companion.ltl.parser import parse
    >>> [in_words(parse(text)) for text in ("at(A) | alarm", "F G at(Home)", "!at(B) U at(A)")]
    ['A or alarm', 'Home for good', 'A before B']
    >>> in_words(parse("F(at(A) & F(at(B) & F at(C)))"))
    'A, then B, then C'
    """
    operands = formula.operands
    match formula.operator:
        case Operator.ATOM:
            fact = Fact.parse(formula.atom)
            return fact.arguments[0] if fact.predicate == AT else str(fact)
        case Operator.NOT:
            return f"not {in_words(operands[0])}"
        case Operator.EVENTUALLY:
            return in_words(operands[0])
        case Operator.ALWAYS if operands[0].operator is Operator.EVENTUALLY:
            return f"{in_words(operands[0])} again and again"
        case Operator.ALWAYS:
            return f"{in_words(operands[0])} for good"
        case Operator.NEXT:
            return f"{in_words(operands[0])} next"
        case Operator.UNTIL | Operator.WEAK_UNTIL if operands[0].operator is Operator.NOT:
            return f"{in_words(operands[1])} before {in_words(operands[0].operands[0])}"
        case Operator.AND:
            return _together(operands)
        case Operator.OR:
            return " or ".join(map(in_words, operands))
        case _:
            return str(formula)


def _together(operands: tuple[Formula, ...]) -> str:
    """What must hold now, then what must come later; rules that always hold are left out."""
    now = [in_words(each) for each in operands if not _is_temporal(each)]
    later = [each for each in operands if _is_temporal(each)]
    due = [in_words(each) for each in later if each.operator is not Operator.ALWAYS]
    then = "; ".join(due or map(in_words, later))
    return ", then ".join(each for each in (" and ".join(now), then) if each)


def _size(formula: Formula) -> int:
    return sum(1 for _ in subformulas(formula))


def _is_temporal(formula: Formula) -> bool:
    """Whether it refers to other positions too."""
    return any(each.operator in TEMPORAL for each in subformulas(formula))
