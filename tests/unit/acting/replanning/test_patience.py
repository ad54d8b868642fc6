"""A mission does not give up at the first cloud: it holds where a plan may come back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rig import Rig
from synthetic import command, event, mission, move, reading

from companion.acting.executive_states import AwaitingPlan, TaskStatus
from companion.flight_events.plans import NoPlanFound, PlanAwaited, PlanReplaced
from companion.flight_events.skills import PlaceReached
from companion.mission.conditions import parse_condition
from companion.mission.events import Event
from companion.mission.model import Mission
from companion.mission.otherwise import PATIENCE_S
from companion.mission.signals import Signal
from companion.mission.skills import Skill
from companion.motion.grid import OccupancyGrid
from companion.outcomes import Failed
from companion.tick import TICK_S

COVERED = event("covered")
CLEAR_A = command("look", "at(A) & !covered", "seen")


def patrol(*events: Event, patience_s: float = PATIENCE_S) -> Mission:
    """A has to be looked at, which needs a clear sky."""
    asked = mission("F seen", skills=[CLEAR_A], events=events or [COVERED])
    return replace(asked, patience_s=patience_s)


def under_way(asked: Mission) -> Rig:
    rig = Rig(asked).begin()
    for _ in range(20):
        rig.tick()
    return rig


def tick_for(rig: Rig, seconds: float) -> None:
    for _ in range(round(seconds / TICK_S)):
        rig.tick()


def test_a_cloud_is_waited_for() -> None:
    rig = under_way(patrol())
    rig.tick(reading("covered"))
    tick_for(rig, 50.0)
    assert isinstance(rig.executive.state, AwaitingPlan)
    assert rig.one(PlanAwaited).hopes == ("covered",)
    rig.tick(reading("covered", 0.0))
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert not rig.of(NoPlanFound)
    assert rig.one(PlanReplaced).reason == "no longer covered"


def test_the_vehicle_holds_meanwhile() -> None:
    rig = under_way(patrol())
    rig.tick(reading("covered"))
    tick_for(rig, 5.0)
    assert rig.vehicle.setpoint is not None
    held = rig.vehicle.setpoint.position
    tick_for(rig, 20.0)
    assert rig.vehicle.setpoint.position == held
    assert rig.vehicle.setpoint.velocity == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("patience_s", [0.0, 5.0, 60.0])
def test_patience_ends(patience_s: float) -> None:
    rig = under_way(patrol(patience_s=patience_s))
    rig.tick(reading("covered"))
    begun_s = rig.flight.now_s
    rig.run(lambda: rig.executive.status is TaskStatus.NO_PLAN)
    assert rig.flight.now_s - begun_s == pytest.approx(patience_s, abs=0.5)
    assert rig.one(NoPlanFound).reason == "covered"


def test_what_brings_no_plan_is_not_why_it_is_given_up() -> None:
    rig = under_way(patrol(COVERED, event("windy"), patience_s=10.0))
    rig.tick(reading("covered"))
    tick_for(rig, 3.0)
    rig.tick(reading("windy"))
    rig.run(lambda: rig.executive.status is TaskStatus.NO_PLAN)
    assert rig.one(NoPlanFound).reason == "covered"


def test_the_last_change_is_why_there_is_a_plan() -> None:
    rig = under_way(patrol(COVERED, event("windy")))
    rig.tick(reading("covered"))
    tick_for(rig, 3.0)
    rig.tick(reading("windy"))
    tick_for(rig, 3.0)
    rig.tick(reading("covered", 0.0))
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.one(PlanReplaced).reason == "no longer covered"


def test_what_flaps_between_a_plan_and_none_ends_with_patience() -> None:
    rig = under_way(patrol(patience_s=20.0))
    begun_s = rig.flight.now_s
    while rig.executive.status is TaskStatus.RUNNING and rig.flight.now_s < begun_s + 60.0:
        rig.tick(reading("covered", float(int(rig.flight.now_s / 2.5) % 2 == 0)))
        rig.vehicle.is_stuck = True  # nothing is reached between
    assert rig.executive.status is TaskStatus.NO_PLAN
    assert rig.flight.now_s - begun_s == pytest.approx(20.0, abs=5.0)


@pytest.mark.parametrize(
    "events",
    [
        pytest.param([replace(COVERED, latch=True)], id="an event that stays"),
        pytest.param(
            [replace(COVERED, when=parse_condition("BATTERY_STATUS.battery_remaining < 30"))],
            id="a battery",
        ),
    ],
)
def test_without_hope_nothing_is_waited_for(events: list[Event]) -> None:
    rig = under_way(patrol(*events))
    battery = Signal("BATTERY_STATUS", "", "battery_remaining")
    rig.tick(reading("covered"), (battery, 20.0))
    tick_for(rig, 1.0)
    assert rig.executive.status is TaskStatus.NO_PLAN and not rig.of(PlanAwaited)


def test_a_battery_event_ends_the_wait() -> None:
    low = replace(event("low"), when=parse_condition("BATTERY_STATUS.battery_remaining < 30"))
    rig = under_way(patrol(COVERED, low))
    rig.tick(reading("covered"))
    tick_for(rig, 2.0)
    rig.tick((Signal("BATTERY_STATUS", "", "battery_remaining"), 20.0))
    tick_for(rig, 1.0)
    assert rig.executive.status is TaskStatus.NO_PLAN


def test_a_violation_is_not_waited_for() -> None:
    """The cloud has been there: to wait makes nothing undone."""
    rig = under_way(mission({"visit": "F at(A)", "never": "G !covered"}, events=[COVERED]))
    rig.tick(reading("covered"))
    tick_for(rig, 1.0)
    assert rig.executive.status is TaskStatus.NO_PLAN and not rig.of(PlanAwaited)


def test_a_change_that_would_give_no_plan_either_is_no_hope() -> None:
    """The payload has refused for good, whether A is covered or not."""
    rig = Rig(patrol()).begin()
    rig.vehicle.payloads.answers = [(1.0, Failed("denied"))]
    rig.run_until(PlaceReached, place="A")
    rig.tick(reading("covered", 0.0))
    rig.run(lambda: rig.executive.status is TaskStatus.NO_PLAN, limit_s=3.0)
    assert not rig.of(PlanAwaited)


def test_a_belief_with_a_return_is_waited_for() -> None:
    asked = mission("F seen", skills=[replace(CLEAR_A, retry_after_s=10.0)], events=[COVERED])
    rig = Rig(asked).begin()
    rig.vehicle.payloads.answers = [(1.0, Failed("denied"))]
    assert rig.run_to_the_end() is TaskStatus.SATISFIED
    assert rig.one(PlanAwaited).hopes == ("can_look",)
    assert len(rig.vehicle.payloads.sent) == 2


def test_an_operator_may_pause_and_go_on_meanwhile() -> None:
    rig = under_way(patrol())
    rig.tick(reading("covered"))
    tick_for(rig, 2.0)
    rig.executive.pause()
    rig.executive.resume()
    tick_for(rig, 2.0)
    assert isinstance(rig.executive.state, AwaitingPlan)
    rig.tick(reading("covered", 0.0))
    assert rig.run_to_the_end() is TaskStatus.SATISFIED


@pytest.mark.parametrize(
    ("move", "reason"),
    [(move(), "a belief came back"), (replace(move(), assumes=()), "the map has changed")],
    ids=["with beliefs", "without"],
)
def test_a_vehicle_that_takes_itself_to_be_walled_in_waits_for_the_map(
    move: Skill, reason: str
) -> None:
    """Walls that are none, all around it: no belief is contradicted, and no way leads anywhere."""
    rig = under_way(mission("G F at(A) & G F at(B)", skills=[move]))
    rig.run_until(PlaceReached, place="A")
    occupied = np.ones((20, 20), dtype=np.bool_)
    rig.flight.routes.see(OccupancyGrid(occupied, 0.5, (-2.0, -2.0)))
    tick_for(rig, 10.0)
    assert isinstance(rig.executive.state, AwaitingPlan)
    rig.flight.routes.see(OccupancyGrid(np.zeros_like(occupied), 0.5, (-2.0, -2.0)))
    rig.run_until(PlaceReached, place="B")
    assert rig.of(PlanReplaced)[-1].reason == reason
