"""Whatever happens: an audit of a flight with optional lines finds what the flight has found."""

from __future__ import annotations

from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st
from rig import Rig
from synthetic import event, mission, reading

from companion.acting.executive_states import TaskStatus
from companion.flight_events.event import Stamped
from companion.record.audit import audit
from companion.record.events import record_of
from companion.tick import TICK_S

EVENTS = [event("rain"), event("wind"), event("again", restarts=["calm"])]
LINES = {
    "watch": "G F at(A) & G F at(H)",
    "dry": "G (rain -> X !at(B))",
    "far": "G F at(B)",
    "calm": "G !wind",
    "quick": "G (wind -> X at(H))",
    "away": "G !at(B)",
}
PRIORITIES = st.permutations([1, 2, 3, 3]).map(lambda n: dict(zip(list(LINES)[2:], n, strict=True)))
CHANGES = st.lists(
    st.tuples(st.floats(0.0, 8.0), st.sampled_from(["rain", "wind", "again"])), max_size=8
)


@given(PRIORITIES, CHANGES)
@drawn(12)
def test_an_audit_finds_what_the_flight_has_found(
    priorities: dict[str, int], changes: list[tuple[float, str]]
) -> None:
    rig = Rig(mission(LINES, events=EVENTS, priorities=priorities)).begin()
    holds = dict.fromkeys(("rain", "wind", "again"), False)
    for after_s, name in changes:
        for _ in range(round(after_s / TICK_S)):
            rig.tick()
        holds[name] = not holds[name]
        rig.tick(reading(name, float(holds[name])))
    for _ in range(round(10.0 / TICK_S)):
        rig.tick()
    assert rig.executive.status is TaskStatus.RUNNING
    positions = [Stamped(99.0, position) for position in rig.positions]
    found = audit(record_of([*rig.reports, *positions]))
    assert found.differs == () and not found.is_failure
    for finding in found.findings:
        dropped = {n for first, last in finding.dropped for n in range(first, last + 1)}
        assert dropped == {p.number for p in rig.positions if finding.name in p.dropped}
        assert finding.priority == priorities.get(finding.name)
        assert finding.priority is not None or not dropped
