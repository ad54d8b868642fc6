"""A changed fence is reported once, in each phase after the checks on the ground."""

from __future__ import annotations

import pytest
from rig import Rig
from synthetic import mission

from companion.acting.sortie.fence_watch import FenceWatch
from companion.acting.sortie.phases import ON_THE_GROUND
from companion.flight_events.fence import FenceChange, FenceChanged
from companion.flight_events.sortie import Phase

CHANGES = [FenceChange.REPLACED, FenceChange.REMOVED]


def changes(phase: Phase, *numbers: int | None) -> list[FenceChange]:
    """What is reported of a fence with these numbers, tick by tick."""
    rig = Rig(mission("F at(A)"))
    watch = FenceWatch(rig.flight)
    for number in numbers:
        rig.vehicle.fence.number = number
        watch.step(phase)
    happened = [stamped.event for stamped in rig.flight.collect_reports()]
    return [event.change for event in happened if isinstance(event, FenceChanged)]


@pytest.mark.parametrize("phase", Phase)
def test_it_is_reported_in_each_phase_after_the_checks(phase: Phase) -> None:
    expected = [] if phase in ON_THE_GROUND else CHANGES
    assert changes(phase, 7, 7, 8, 8, 0, 0) == expected


def test_what_is_first_heard_or_not_heard_for_a_while_is_no_change() -> None:
    assert changes(Phase.TASK, None, 7, None, 7) == []


def test_an_autopilot_that_numbers_no_fences_changes_none() -> None:
    assert changes(Phase.TASK, 0, 0, 0) == []
