"""Audits a recorded flight: each conjunct of its task against the word that was executed.

1. The word is read from the record alone, letter by letter, by a monitor of each conjunct
   (`companion/ltl/monitor.py`). If the vehicle has come to rest for ever, the word is a lasso, and
   the semantics of LTL decides each conjunct directly, without any automaton.
2. A line with a time bound is also read by its clock (`timed_word.py`). If the clock runs out, the
   position that was left last has violated the line.
3. An event may have restarted conjuncts (`restarts`). What such a conjunct has read before is then
   dropped, but a violation remains. This differs from the formula's truth over the whole flight, so
   the outcome without restarts is reported too.
4. A line with a priority is dropped where no plan keeps it. It still reads the word and is judged
   like all others, but the flight does not fail because of it. If it was violated, it restarts when
   it is taken up again, and is judged from there. The positions at which it was dropped are
   reported.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from enum import Enum

from companion.flight_events.word import PositionLeft
from companion.ltl.formula import Formula
from companion.ltl.monitor import Monitor, TruthValue
from companion.ltl.semantics import Letter, holds
from companion.ltl.time_bounds import TimeBound
from companion.ltl.timed_formula import parts
from companion.record.events import RunRecord


class ConjunctOutcome(Enum):
    """The result of a conjunct in a flight; the first two are failures."""

    VIOLATED = "violated"
    UNFULFILLED = "unfulfilled"
    FULFILLED = "fulfilled"
    SATISFIED = "satisfied"
    OPEN = "open"

    @property
    def is_failure(self) -> bool:
        """Whether the flight does not satisfy the conjunct."""
        return self in (ConjunctOutcome.VIOLATED, ConjunctOutcome.UNFULFILLED)


@dataclass(frozen=True, slots=True, repr=False)
class Finding:
    """The result of one conjunct in a flight.

    Attributes:
        formula: with its time bound, if it has one.
        outcome: VIOLATED and FULFILLED if the word alone decides it, at `position`; SATISFIED and
            UNFULFILLED if the rest that follows for ever decides it; otherwise OPEN: not violated
            so far.
        since: the position of its last restart, 0 if there was none. What was read before is
            dropped, except for a violation.
        priority: the priority of a line that may be dropped; None for all others.
        dropped: first and last position of each span in which the plan did not keep it.
        whole: the outcome over the whole flight, as without restarts; it differs from `outcome`
            only where `restarts` asks for the paper's forgetting.
        states: what the word says after each position.
    """

    name: str
    formula: Formula | TimeBound
    outcome: ConjunctOutcome
    position: int | None
    since: int
    whole: ConjunctOutcome
    states: tuple[TruthValue, ...]
    priority: int | None = None
    dropped: tuple[tuple[int, int], ...] = ()

    @property
    def is_failure(self) -> bool:
        """Whether the flight fails because of it."""
        return self.outcome.is_failure and self.priority is None

    def __repr__(self) -> str:
        """One line, without the state at each position."""
        return f"<Finding on {self.name}: {self.verdict}, {self.formula}>"

    @property
    def verdict(self) -> str:
        """The outcome in words, with the position that decides it."""
        at = "" if self.position is None else f" at position {self.position}"
        return f"{self.outcome.value}{at}"


@dataclass(frozen=True, slots=True, repr=False)
class Audit:
    """All findings.

    Attributes:
        differs: violations, as conjunct and position, that only the flight or only the audit has
            found.
            has found.
    """

    findings: tuple[Finding, ...]
    differs: tuple[tuple[str, int], ...]

    def __repr__(self) -> str:
        """One line: failures by name, and the number of each other outcome."""
        failed = [each for each in self.findings if each.outcome.is_failure]
        told = [
            f"{each.name}{'' if each.is_failure else ' (optional)'} {each.verdict}"
            for each in failed
        ]
        rest = Counter(each.outcome.value for each in self.findings if each not in failed)
        told += [f"{number} {outcome}" for outcome, number in rest.items()]
        return f"<Audit: {', '.join(told) or 'no task'}>"

    @property
    def is_failure(self) -> bool:
        """Whether the flight does not satisfy the task."""
        return any(finding.is_failure for finding in self.findings)


def audit(record: RunRecord) -> Audit:
    """Audits a recorded flight.

    Raises:
        TranslationLimit: the monitor of a conjunct would be too large.
    """
    readings = [
        _read(AuditedConjunct(name, formula, bound), record)
        for name, line in record.task.items()
        for formula, bound in parts(line)
    ]
    found = {(reading.part.name, number) for reading in readings for number in reading.violated}
    differs = tuple(sorted(found ^ record.violations))
    return Audit(tuple(_finding(reading, record) for reading in readings), differs)


@dataclass(frozen=True, slots=True)
class AuditedConjunct:
    """A conjunct of a line of the task, as it is audited.

    Attributes:
        name: the name of the line.
        formula: without its time bound.
        bound: None if it has none.
    """

    name: str
    formula: Formula
    bound: TimeBound | None

    @property
    def said(self) -> Formula | TimeBound:
        """The formula with its time bound."""
        return self.bound or self.formula


@dataclass(frozen=True, slots=True)
class _Reading:
    """What the word says about a conjunct.

    Attributes:
        begun: number of the position from which it counts.
        states: what is known after each position.
        violated: the positions that violated it: one, and perhaps one more after each restart.
    """

    part: AuditedConjunct
    begun: int
    states: tuple[TruthValue, ...]
    violated: tuple[int, ...]

    @property
    def since_begun(self) -> _Reading:
        """The same without what lies before its last restart."""
        return replace(self, violated=tuple(n for n in self.violated if n >= self.begun))


def _read(part: AuditedConjunct, record: RunRecord, restarts: bool = True) -> _Reading:
    fresh = monitor = Monitor.of(part.formula)
    overruns: Collection[int] = ()
    if part.bound is not None:
        overruns = record.in_time.overruns(part.bound, part.name, restarts)
    begun, is_late, is_false, states, violated = 0, False, False, [], set(overruns)
    for position in record.positions:
        if restarts and part.name in position.restarted:
            monitor, begun, is_late, is_false = fresh, position.number, False, False
        monitor, was_false = monitor.after(frozenset(position.facts)), is_false
        is_false = monitor.truth_value is TruthValue.FALSE
        is_late = is_late or position.number in overruns
        states.append(TruthValue.FALSE if is_late else monitor.truth_value)
        if is_false and not was_false:
            violated.add(position.number)
    return _Reading(part, begun, tuple(states), tuple(sorted(violated)))


def _finding(reading: _Reading, record: RunRecord) -> Finding:
    positions, priority = record.positions, record.priorities.get(reading.part.name)
    judged = reading if priority is None else reading.since_begun
    outcome, number = _outcome(judged, positions)
    whole = outcome
    if reading.begun:
        not_restarted = _read(reading.part, record, restarts=False)
        whole, _ = _outcome(not_restarted, positions)
    return Finding(
        name=reading.part.name,
        formula=reading.part.said,
        outcome=outcome,
        position=number,
        since=reading.begun,
        whole=whole,
        states=reading.states,
        priority=priority,
        dropped=_spans(p.number for p in positions if reading.part.name in p.dropped),
    )


def _spans(numbers: Iterable[int]) -> tuple[tuple[int, int], ...]:
    """The spans of consecutive numbers.

    >>> _spans([2, 3, 4, 7])
    ((2, 4), (7, 7))
    """
    spans: list[tuple[int, int]] = []
    for number in numbers:
        if spans and spans[-1][1] == number - 1:
            spans[-1] = (spans[-1][0], number)
        else:
            spans.append((number, number))
    return tuple(spans)


def _outcome(
    reading: _Reading, positions: tuple[PositionLeft, ...]
) -> tuple[ConjunctOutcome, int | None]:
    """The outcome of a reading, and the position that decides it, if the word does."""
    if reading.violated:
        return ConjunctOutcome.VIOLATED, reading.violated[0]
    if TruthValue.TRUE in reading.states[reading.begun :]:
        return ConjunctOutcome.FULFILLED, reading.states.index(TruthValue.TRUE, reading.begun)
    if positions and positions[-1].for_ever:
        word: list[Letter] = [frozenset(each.facts) for each in positions[reading.begun :]]
        is_satisfied = holds(reading.part.formula, word[:-1], word[-1:])
        outcome = ConjunctOutcome.SATISFIED if is_satisfied else ConjunctOutcome.UNFULFILLED
        return outcome, None
    return ConjunctOutcome.OPEN, None


def as_json(record: RunRecord, result: Audit) -> Mapping[str, object]:
    """Record and findings for programs."""
    return {
        "satisfied": not result.is_failure,
        "at_rest": bool(record.positions) and record.positions[-1].for_ever,
        "ending": record.ending and record.ending.text,
        "torn": record.is_torn,
        "differs": [{"conjunct": name, "position": number} for name, number in result.differs],
        "conjuncts": [
            {
                "conjunct": finding.name,
                "formula": str(finding.formula),
                "outcome": finding.outcome.value,
                "position": finding.position,
                "since": finding.since,
                "whole": finding.whole.value,
                "priority": finding.priority,
                "dropped": [list(span) for span in finding.dropped],
            }
            for finding in result.findings
        ],
        "positions": [
            {
                "number": position.number,
                "t_s": time_s,
                "facts": sorted(position.facts),
                "risen": sorted(position.risen),
                "withdrawn": sorted(position.withdrawn),
                "restarted": sorted(position.restarted),
                "dropped": sorted(position.dropped),
                "states": [finding.states[position.number].value for finding in result.findings],
            }
            for position, time_s in zip(record.positions, record.times_s, strict=True)
        ],
    }
