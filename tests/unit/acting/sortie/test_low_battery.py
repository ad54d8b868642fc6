"""A low battery calls the vehicle home, where its mission does not say what is done then."""

from __future__ import annotations

from typing import Any

import pytest
from sortie_rig import SortieRig, aborted
from synthetic import mission, skill

from companion.acting.sortie.flight_limit import FlightLimit
from companion.acting.sortie.low_battery import IN_FLIGHT, LOW_S, ON_GROUND, says_what_then
from companion.flight_events.sortie import (
    BatteryLow,
    Phase,
    PhaseEntered,
    ReturnedAsAsked,
    ReturnFailed,
)
from companion.mission.conditions import parse_condition
from companion.mission.events import Event
from companion.mission.model import Mission
from companion.mission.otherwise import LandAtSafePlace
from companion.mission.steps import Charge
from companion.tick import TICK_S
from companion.vehicle.ports.control import Takeover
from companion.vehicle.ports.state import Mode

PATROL = "G F at(A) & G F at(B)"


def flown(asked: Mission | None = None, **options: Any) -> SortieRig:
    return SortieRig(asked or mission(PATROL), **options).until(Phase.TASK).run(2.0)


def make_low(run: SortieRig, since_s: float | None = None) -> None:
    now_s = run.rig.flight.now_s
    run.vehicle.change(battery_low_since_s=now_s if since_s is None else since_s)


def with_event(condition: str) -> Mission:
    watched = Event("low", parse_condition(condition), None, True, 0.0, frozenset())
    return mission(PATROL, events=[watched])


def test_it_flies_home_and_lands_and_the_task_has_not_ended_well() -> None:
    run = flown()
    make_low(run)
    run.until(Phase.ENDED)
    assert run.of(BatteryLow) == [BatteryLow("H")]
    assert run.reports[-1].event == aborted(IN_FLIGHT)
    state = run.vehicle.state
    assert state is not None and state.is_landed and abs(state.motion.position[0]) < 0.3


def test_it_flies_to_the_safe_place_that_is_reached_soonest() -> None:
    run = flown(mission(PATROL, places="HABC", otherwise=LandAtSafePlace(("H", "C"))))
    while "B" not in run.places:
        run.step()
    make_low(run, since_s=run.rig.flight.now_s - LOW_S)
    run.until(Phase.ENDED)
    assert run.of(BatteryLow) == [BatteryLow("C")]
    assert run.reports[-1].event == aborted(IN_FLIGHT)


def test_a_load_that_is_short_does_not_call_it_home() -> None:
    run = flown()
    make_low(run)
    run.run(LOW_S - 2 * TICK_S)
    run.vehicle.change(battery_low_since_s=None)
    run.run(2 * LOW_S)
    assert (run.sortie.phase, run.of(BatteryLow)) == (Phase.TASK, [])
    make_low(run)
    run.run(LOW_S - 2 * TICK_S)
    assert not run.of(BatteryLow)
    run.run(3 * TICK_S)
    assert run.of(BatteryLow) and run.sortie.phase is Phase.RETURNING


@pytest.mark.parametrize(
    "condition", ["BATTERY_STATUS.battery_remaining < 9", "SYS_STATUS.voltage_battery < 14000"]
)
def test_a_mission_that_watches_its_battery_flies_on(condition: str) -> None:
    run = flown(with_event(condition))
    make_low(run)
    run.run(2 * LOW_S)
    assert run.sortie.phase is Phase.TASK and not run.of(BatteryLow)


def test_what_a_mission_says_of_its_battery() -> None:
    charging = skill("charge", Charge(90), "", "at(H)", [], "charged")
    assert says_what_then(mission(PATROL, skills=[charging]))
    assert not says_what_then(mission(PATROL))
    assert not says_what_then(with_event("SYS_STATUS.load > 900"))


def test_a_pause_ends_by_it() -> None:
    run = flown()
    assert run.sortie.pause() is None
    make_low(run)
    run.until(Phase.ENDED)
    assert run.of(BatteryLow) and run.reports[-1].event == aborted(IN_FLIGHT)
    assert PhaseEntered(Phase.RETURNING) in run.events


def test_a_pause_of_a_flight_home_ends_by_it_and_the_flight_ends_as_asked() -> None:
    run = flown()
    assert run.sortie.return_home() is None
    run.run(0.2)
    assert run.sortie.pause() is None
    make_low(run)
    run.until(Phase.ENDED)
    assert run.reports[-1].event == ReturnedAsAsked()


def test_it_waits_for_a_pilot_who_has_the_vehicle() -> None:
    run = flown(may_yield=True)
    run.vehicle.change(mode=Mode.LOITER)
    run.vehicle.control.takeover = Takeover(Mode.LOITER, is_failsafe=False)
    make_low(run)
    run.run(2 * LOW_S)
    assert run.sortie.phase is Phase.YIELDED and not run.of(BatteryLow)
    assert run.sortie.resume() is None
    run.until(Phase.ENDED)
    assert run.reports[-1].event == aborted(IN_FLIGHT)


def test_the_reason_is_the_battery_where_there_is_no_way_home_either() -> None:
    run = flown()
    make_low(run)
    run.until(Phase.RETURNING)
    run.vehicle.drift = (0.0, 0.9, 0.0)
    run.until(Phase.ENDED)
    assert run.of(ReturnFailed) and run.reports[-1].event == aborted(IN_FLIGHT)


def test_a_limit_of_the_flight_at_the_same_time_is_what_is_told() -> None:
    run = flown(limit=FlightLimit(duration_s=20.0))
    armed = PhaseEntered(Phase.ARMING)
    armed_s = next(stamped.time_s for stamped in run.reports if stamped.event == armed)
    make_low(run, since_s=armed_s + 20.0 - LOW_S)
    run.until(Phase.ENDED)
    assert run.sortie.failure is None and not run.of(BatteryLow)


def test_with_a_low_battery_it_is_not_armed() -> None:
    run = SortieRig(mission(PATROL))
    make_low(run, since_s=0.0)
    run.until(Phase.ENDED)
    assert PhaseEntered(Phase.ARMING) not in run.events
    assert run.reports[-1].event == aborted(ON_GROUND)
    said = SortieRig(with_event("BATTERY_STATUS.battery_remaining < 9"))
    make_low(said, since_s=0.0)
    assert said.until(Phase.TASK).sortie.failure is None
