"""An audit as a Python program prints it."""

from __future__ import annotations

import pytest

from companion.flight_events.event import Stamped
from companion.flight_events.plans import WrittenTreeAdopted
from companion.flight_events.word import ConjunctViolated, PositionLeft
from companion.ltl.monitor import TruthValue
from companion.ltl.parser import parse
from companion.record.audit import Audit, ConjunctOutcome, Finding, audit
from companion.record.events import record_of

VIOLATED, SATISFIED = ConjunctOutcome.VIOLATED, ConjunctOutcome.SATISFIED


def finding(
    name: str, outcome: ConjunctOutcome, at: int | None = None, priority: int | None = None
) -> Finding:
    states = (TruthValue.INCONCLUSIVE,) * 1000
    return Finding(name, parse("G !wet"), outcome, at, 0, outcome, states, priority)


@pytest.mark.parametrize(
    ("findings", "printed"),
    [
        ((), "<Audit: no task>"),
        ((finding("a", SATISFIED), finding("b", SATISFIED)), "<Audit: 2 satisfied>"),
        (
            (finding("a", SATISFIED), finding("dry", VIOLATED, 4), finding("b", VIOLATED, 5, 1)),
            "<Audit: dry violated at position 4, b (optional) violated at position 5, 1 satisfied>",
        ),
    ],
)
def test_an_audit_is_printed_in_a_line(findings: tuple[Finding, ...], printed: str) -> None:
    assert str(Audit(findings, ())) == printed


def test_a_finding_is_printed_without_all_that_was_read() -> None:
    printed = str(finding("dry", VIOLATED, 4))
    assert printed == "<Finding on dry: violated at position 4, G !wet>"


def test_a_line_that_nothing_satisfies_is_violated_by_the_first_position() -> None:
    never, facts = "F(lit & !lit)", ("at(A)",)
    left = [PositionLeft(n, facts, (), float(n), (), (), for_ever=False) for n in range(3)]
    told = ConjunctViolated("never", never, 0, facts)
    events = [WrittenTreeAdopted({"never": never}), left[0], told, *left[1:]]
    found = audit(record_of([Stamped(float(n), each) for n, each in enumerate(events)]))
    assert repr(found) == "<Audit: never violated at position 0>"
    assert found.differs == ()
