"""A plan that becomes late while one of its actions is under way, and the plan instead of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pytest
from rig import Rig
from synthetic import event, mission, skill

from companion.acting.positions import tell_late
from companion.acting.replanning.late_plans import LatePlans
from companion.acting.replanning.replanner import BetterPlan, Replanner
from companion.errors import NoPlanError
from companion.flight_events.plans import LineDropped, PlanReplaced
from companion.flight_events.skills import PlaceReached, SkillCompleted
from companion.flight_events.word import ConjunctViolated
from companion.mission.steps import Command
from companion.outcomes import Progress
from companion.planning.optional_lines import NO_PLAN
from companion.planning.time_check import LateLine

USER_1 = Command(25, 31010, "MAV_CMD_USER_1", ())
LIMIT_S, LEG_S = 30.0, 5.0
SOON = {"soon": f"F[<={LIMIT_S:g}s] at(B)"}
LOOK = skill("look", USER_1, "", "at(A)", (), "seen")


class ClockedRig(Rig):
    """A rig whose task has clocks."""

    def pass_time(self) -> None:
        super().pass_time()
        self.task.word.now_s = self.flight.now_s
        tell_late(self.flight)

    def at(self, place: str) -> float:
        """When a place was reached first."""
        self.run_until(PlaceReached, place=place)
        return self.flight.now_s


def looking(task: Mapping[str, str], answers_after_s: float, **more: Any) -> ClockedRig:
    """A look at A, on the way to B, takes longer than the three seconds of its cost."""
    rig = ClockedRig(mission({**SOON, **task}, **{"skills": [LOOK]} | more)).begin()
    rig.vehicle.payloads.answers = [(answers_after_s, Progress.DONE)]
    assert isinstance(rig, ClockedRig)
    assert rig.plans[0].names(3) == ["move(H, A)", "look", "move(A, B)"]
    return rig


def test_a_skill_that_works_too_long_is_done_after_what_has_a_bound() -> None:
    rig = looking({"look": "F seen"}, 200.0)
    reached_s = rig.at("B")
    assert LIMIT_S - 2 * LEG_S < reached_s < LIMIT_S
    replan = rig.one(PlanReplaced)
    assert replan.plan.prefix[0].action == "move(A, B)"
    assert replan.reason.startswith("soon: F[<=30s] at(B) has ")
    assert "s to spare after move(A, B)" in replan.reason
    rig.run_until(SkillCompleted)


def test_what_takes_longer_but_not_too_long_changes_nothing() -> None:
    """It ends when more than half of the margin is left, and most of it is used up."""
    rig = looking({"look": "F seen"}, LIMIT_S - 2 * LEG_S - 1.5)
    assert rig.at("B") > LIMIT_S - 3.0
    assert not rig.of(PlanReplaced) and len(rig.of(SkillCompleted)) == 1


@pytest.mark.parametrize("priorities", [{"first": 1}, {"first": 1, "soon": 2}])
def test_a_less_important_line_is_dropped_for_the_bound(priorities: dict[str, int]) -> None:
    rig = looking({"home": "F at(A)", "first": "!at(B) U seen"}, 200.0, priorities=priorities)
    assert rig.at("B") < LIMIT_S
    assert rig.of(LineDropped) == [LineDropped("first", NO_PLAN)]


@pytest.mark.parametrize("priorities", [{}, {"soon": 1}, {"soon": 1, "first": 2}])
def test_a_bound_that_no_plan_can_keep_is_asked_about_once_or_twice(
    priorities: dict[str, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Once before the limit and once after; the skill works on."""
    asked: list[Sequence[LateLine]] = []
    soon_better = LatePlans._soon_better

    def counted(plans: LatePlans, late: Sequence[LateLine]) -> BetterPlan | None:
        asked.append(late)
        return soon_better(plans, late)

    monkeypatch.setattr(LatePlans, "_soon_better", counted)
    rig = looking({"home": "F at(A)", "first": "!at(B) U seen"}, 200.0, priorities=priorities)
    rig.run_until(ConjunctViolated)
    assert rig.flight.now_s > LIMIT_S
    assert 1 <= len(asked) <= 2
    assert rig.of(PlanReplaced) == [] or rig.flight.now_s > LIMIT_S


def test_the_plan_that_was_found_is_flown_though_another_search_would_find_none(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(Replanner, "_solve", lambda *_: NoPlanError("it is gone"))
    rig = looking({"look": "F seen"}, 200.0)
    assert rig.at("B") < LIMIT_S
    assert rig.one(PlanReplaced).plan.prefix[0].action == "move(A, B)"


def test_a_skill_that_has_taken_too_long_is_followed_by_what_has_a_bound(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The way to B was to lead past C, which is too long now."""
    monkeypatch.setattr(Replanner, "_solve", lambda *_: NoPlanError("it is gone"))
    monkeypatch.setattr(LatePlans, "under_way", lambda *_: None)
    task = {**SOON, "look": "F seen", "far": "F at(C)", "end": "F G at(B)"}
    rig = ClockedRig(mission(task, places="HABC", skills=[LOOK])).begin()
    assert rig.plans[0].names(4) == ["move(H, A)", "look", "move(A, C)", "move(C, B)"]
    rig.vehicle.payloads.answers = [(LIMIT_S - 2 * LEG_S, Progress.DONE)]
    assert isinstance(rig, ClockedRig)
    assert rig.at("B") < LIMIT_S
    assert rig.one(PlanReplaced).plan.prefix[0].action == "move(here, B)"
    rig.run_until(PlaceReached, place="C")


def test_a_plan_that_was_found_before_something_changed_is_searched_again() -> None:
    task = {"look": "F seen", "alarm": "G(alarm -> F at(H))"}
    rig = looking(task, 200.0, events=[event("alarm")])
    under_way = LatePlans.under_way

    def changed(plans: LatePlans, *asked: Any) -> BetterPlan | None:
        better = under_way(plans, *asked)
        if better is not None:
            rig.task.take(event("alarm"), True)
        return better

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(LatePlans, "under_way", changed)
        rig.run_until(PlanReplaced)
    assert "move(A, H)" in {each.action for each in rig.one(PlanReplaced).plan.prefix}


def test_a_skill_on_the_ground_is_finished_first() -> None:
    rig = looking({"look": "F seen"}, 200.0)
    rig.run_until(PlaceReached, place="A")
    rig.flight.progress.take_to_ground()
    rig.run(lambda: rig.flight.now_s > LIMIT_S - LEG_S)
    assert not rig.of(PlanReplaced)


def test_a_flight_that_is_slower_than_planned_gives_way_to_another_one() -> None:
    """The vehicle was to fly past A, which the order allows, and B would be late."""
    task = {"soon": "F[<=13s] at(B)", "far": "F at(A)", "end": "F G at(H)"}
    rig = ClockedRig(mission(task, places="HAB")).begin()
    assert rig.plans[0].names(2) == ["move(H, A)", "move(A, B)"]
    rig.run(lambda: rig.flight.now_s > 1.5)
    rig.speed_limit.set_operator_limit(1.15)
    assert isinstance(rig, ClockedRig)
    assert rig.at("B") < 13.0
    assert not rig.of(ConjunctViolated)
    assert not rig.of(PlaceReached, place="A")
    rig.run_until(PlaceReached, place="A")


def test_a_flight_that_no_other_one_outruns_goes_on() -> None:
    rig = ClockedRig(mission({"soon": "F[<=13s] at(B)"}, places="HB")).begin()
    rig.run(lambda: rig.flight.now_s > 1.5)
    rig.speed_limit.set_operator_limit(0.5)
    rig.run_until(ConjunctViolated)
    rig.executive.stop()
    assert not [each for each in rig.of(PlanReplaced) if "violated" not in each.reason]
