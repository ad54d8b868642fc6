"""A failure that the task mentions is read, however soon the belief comes back.

From A the vehicle flies to B in some seconds; what it assumes of its camera comes back after one.
"""

from __future__ import annotations

from dataclasses import replace

import pytest
from rig import Rig
from synthetic import command, mission

from companion.acting.executive_states import TaskStatus
from companion.flight_events.facts import BeliefRestored
from companion.flight_events.plans import LapCompleted
from companion.flight_events.skills import PlaceReached, SkillFailed
from companion.mission.skills import Skill
from companion.outcomes import Failed

LOOK = replace(command("look", "at(A)", "seen"), retry_after_s=1.0)
PATROL = "G F at(A) & G F at(B)"


def refused(task: str, *others: Skill) -> Rig:
    """The camera has refused, and two more places are reached."""
    rig = Rig(mission(task, skills=[LOOK, *others])).begin()
    rig.vehicle.payloads.answers = [(1.0, Failed("denied"))]
    rig.run_until(SkillFailed)
    rig.run_until(PlaceReached, times=3)
    return rig


def told(rig: Rig) -> list[str]:
    """The places that were reached, and what came back meanwhile."""
    kinds = (PlaceReached, BeliefRestored)
    return [each.text for each in rig.events if isinstance(each, kinds)]


def test_a_belief_comes_back_after_the_position_that_reads_its_failure() -> None:
    rig = refused(f"{PATROL} & F (seen | !can_look)")
    assert told(rig) == ["at A", "at B", "belief can_look restored", "at A"]


def test_so_a_task_that_asks_for_the_failure_is_done_with_it() -> None:
    """It flew to A again and again, to look or to see it fail."""
    rig = refused(f"{PATROL} & F (seen | !can_look)")
    rig.run_until(PlaceReached, times=7)
    assert len(rig.vehicle.payloads.sent) == 1


def test_a_belief_that_the_task_does_not_mention_comes_back_on_the_way() -> None:
    rig = refused(f"{PATROL} & F seen", command("stare", "at(B)", "seen"))
    assert told(rig)[:3] == ["at A", "belief can_look restored", "at B"]


@pytest.mark.parametrize(
    "task", ["F seen", "F (seen & can_look)", "F seen & G F (can_look | seen)"]
)
def test_who_waits_for_it_in_want_of_a_plan_waits_no_longer_than_was_said(task: str) -> None:
    rig = Rig(mission(task, skills=[LOOK])).begin()
    rig.vehicle.payloads.answers = [(1.0, Failed("denied"))]
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert len(rig.of(BeliefRestored)) == 1


def test_laps_are_counted_on_where_what_came_back_leaves_the_plan_as_it_was() -> None:
    """The second lap was told as the first one again."""
    rig = refused(f"{PATROL} & F (seen | !can_look)")
    rig.run_until(LapCompleted, times=3)
    assert [lap.lap for lap in rig.of(LapCompleted)] == [1, 2, 3]
