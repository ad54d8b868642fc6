"""What is still due, in words: the part of the task that the flight so far has left to be done.

Goals that recur for ever (`G F p`) are due once in each lap: a lap is over as soon as each of them
has been met, and the next one begins with the position after that. What other lines demand is what
formula progression leaves of them (`companion/ltl/progression.py`); what always holds, such as
`G !at(D)`, is a rule and not due. Lines that plans do not keep are not due, and no part of a lap.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from companion.ltl.formula import FALSE, TRUE, Formula, Operator, conjuncts, subformulas
from companion.ltl.progression import progressed
from companion.ltl.semantics import Letter
from companion.mission.facts import AT, Fact

MOST_NODES = 60
"""Of what is left of a line; what is larger is not told, as nobody would read it."""
TEMPORAL = frozenset(
    {
        Operator.NEXT,
        Operator.EVENTUALLY,
        Operator.ALWAYS,
        Operator.UNTIL,
        Operator.RELEASE,
        Operator.WEAK_UNTIL,
    }
)


@dataclass
class DueLine:
    """A conjunct of the task as it is read: what it is, and what is left of it."""

    name: str
    formula: Formula

    def __post_init__(self) -> None:
        self.rest = self.formula
        self.is_dropped = False
        self.is_met = False

    @property
    def recurring(self) -> Formula | None:
        """The goal that has to hold again and again, if that is all that it says."""
        if self.formula.operator is not Operator.ALWAYS:
            return None
        inner = self.formula.operands[0]
        is_goal = inner.operator is Operator.EVENTUALLY and not _is_temporal(inner.operands[0])
        return inner.operands[0] if is_goal else None

    @property
    def words(self) -> list[str]:
        """What is due of it, in words."""
        if (goal := self.recurring) is not None:
            return [] if self.is_met else [f"{in_words(goal)} still due in this lap"]
        left = [each for each in conjuncts(self.rest) if each.operator is not Operator.ALWAYS]
        return [
            f"{in_words(each)} {'still due' if _is_temporal(each) else 'due at the next position'}"
            for each in left
            if each not in (TRUE, FALSE)
        ]


class Obligations:
    """Reads the word of a flight, and says what is due."""

    def __init__(self, lines: Sequence[tuple[str, Formula]]) -> None:
        self.lines = [DueLine(name, formula) for name, formula in lines]

    @property
    def _recurring(self) -> list[DueLine]:
        return [each for each in self.lines if each.recurring is not None and not each.is_dropped]

    def read(self, letter: Letter, restarted: Collection[str]) -> None:
        """One more position; the named lines begin anew with it."""
        if all(each.is_met for each in self._recurring):
            for each in self._recurring:
                each.is_met = False
        for each in self.lines:
            begun = each.formula if each.name in restarted else each.rest
            if (goal := each.recurring) is not None:
                each.is_met |= progressed(goal, letter).operator is Operator.TRUE
            else:
                rest = progressed(begun, letter)
                each.rest = rest if sum(1 for _ in subformulas(rest)) <= MOST_NODES else TRUE

    def drop(self, name: str, is_dropped: bool) -> None:
        """Plans do not keep a line any more, or keep it again."""
        for each in self.lines:
            if each.name == name:
                each.is_dropped = is_dropped

    @property
    def due(self) -> tuple[tuple[str, str], ...]:
        """The name of a line and what is due of it, each in words."""
        return tuple(
            (each.name, text) for each in self.lines if not each.is_dropped for text in each.words
        )


def in_words(formula: Formula) -> str:
    """What a formula demands, as people say it.

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
    """What holds at once, and then what comes later; rules that always hold are left out."""
    now = [in_words(each) for each in operands if not _is_temporal(each)]
    later = [each for each in operands if _is_temporal(each)]
    due = [in_words(each) for each in later if each.operator is not Operator.ALWAYS]
    then = "; ".join(due or map(in_words, later))
    return ", then ".join(each for each in (" and ".join(now), then) if each)


def _is_temporal(formula: Formula) -> bool:
    return any(each.operator in TEMPORAL for each in subformulas(formula))
