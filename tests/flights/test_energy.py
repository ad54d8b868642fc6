"""Flights on a battery that is too small for the task: docks, surprises, and ways out."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from random import Random
from typing import Any

import pytest
from lockstep import Lockstep
from two_docks import PADS, RESERVE, between_docks, lowest, text, two_docks

from companion.acting.behaviour_tree import landing
from companion.flight_events.charge import ChargeMeasured, ChargePlanned
from companion.flight_events.energy import EnergyUsed, ReserveUsed
from companion.flight_events.facts import BeliefWithdrawn
from companion.flight_events.plans import LapCompleted, NoPlanFound, PlanAwaited, PlanReplaced
from companion.flight_events.skills import PlaceReached, SkillCompleted
from companion.flight_events.sortie import (
    ChargeAwaited,
    ControlRegained,
    ControlTakenBack,
    Phase,
    PhaseEntered,
    VehicleLanded,
)
from companion.flights.simulated_world import world_of
from companion.mavlink.framing import dialect
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.planning.builtin.search import Search
from companion.planning.charger import UNITS_PER_WH
from companion.planning.planner import Planner
from companion.tick import TICK_S

CONTINUE = dialect.MAV_CMD_DO_PAUSE_CONTINUE
COMPANION = 191


MISSION = load_mission(two_docks())


def fly(
    *happens: dict[str, Any],
    charge: float = 0.27,
    mission: Mission = MISSION,
    pads: list[dict[str, Any]] = PADS,
    **options: Any,
) -> Lockstep:
    scenario = between_docks(*happens, charge=charge, pads=pads)
    return Lockstep(mission, world_of(mission, scenario), seed=1, **options)


def charges(flight: Lockstep) -> int:
    return sum(each.action.startswith("recharge(") for each in flight.of(SkillCompleted))


def percent(flight: Lockstep) -> float:
    """What truly is there."""
    return 100 * flight.simulation.flight.charge


def test_it_goes_on_for_ever_and_keeps_the_reserve() -> None:
    flight = fly()
    assert lowest(flight, 100.0) >= RESERVE
    assert charges(flight) >= 2
    assert not flight.of(PlanReplaced) and not flight.of(NoPlanFound), text(flight)
    assert {*flight.places} == {"A", "B", "E"}
    tells_its_charge(flight)


def tells_its_charge(flight: Lockstep) -> None:
    """The gauge and the plans, lap after lap, are in the record: what is there lasts."""
    told = [stamped.event for stamped in flight.recorded]
    measured = [event.percent for event in told if isinstance(event, ChargeMeasured)]
    assert len(measured) > 8 and all(a != b for a, b in pairwise(measured))
    assert abs((measured[-1] or 0) - percent(flight)) <= 2
    plans = [event for event in told if isinstance(event, ChargePlanned)]
    assert len(plans) == 1 + len(flight.of(LapCompleted))
    for plan in plans:
        assert plan.percent >= plan.required_percent >= RESERVE
        assert all(at.percent >= at.required_percent for at in plan.ahead)
    done = [each.action for each in plans[0].ahead]
    flown = [e.action for e in flight.events if isinstance(e, PlaceReached | SkillCompleted)]
    assert done == flown[: len(done)]


@pytest.mark.long
def test_a_full_battery_lands_on_no_dock() -> None:
    flight = fly(charge=0.9)
    flight.run(45.0)
    assert charges(flight) >= 2 and flight.armings == 1
    assert not flight.of(VehicleLanded)


def test_with_little_it_charges_first() -> None:
    """What it can do is known before it takes off."""
    flight = fly(charge=0.242)
    assert lowest(flight, 45.0) >= RESERVE
    assert flight.places[0] in ("W", "E") and flight.of(VehicleLanded), text(flight)
    assert not flight.of(NoPlanFound), text(flight)


@pytest.mark.parametrize(
    "at_s", [18.0, *(pytest.param(at_s, marks=pytest.mark.long) for at_s in (10.0, 26.0, 33.0))]
)
def test_charge_that_is_lost_in_flight_makes_it_charge_first(at_s: float) -> None:
    flight = fly({"at_s": at_s, "battery": {"charge": 0.235}}, charge=0.5)
    assert lowest(flight, 70.0) >= RESERVE - 0.2
    assert not flight.of(NoPlanFound), text(flight)
    assert flight.of(VehicleLanded) and charges(flight) >= 2
    assert {"A", "B"} <= {*flight.places}


@pytest.mark.long
@pytest.mark.parametrize("at_s", [12.0, 25.0])
def test_with_too_little_for_any_plan_it_charges_on_the_reserve_and_goes_on(at_s: float) -> None:
    flight = fly({"at_s": at_s, "battery": {"charge": 0.205}}, charge=0.5)
    assert lowest(flight, 95.0) > RESERVE - 4
    assert len(flight.of(ReserveUsed)) == 1, text(flight)
    assert not flight.of(NoPlanFound) and not flight.companion.has_ended
    assert charges(flight) >= 2 and {"A", "B"} <= {*flight.places}
    assert "flights take" not in "".join(e.reason for e in flight.of(PlanReplaced))


@pytest.mark.long
@pytest.mark.parametrize("seed", range(24))
def test_charge_that_is_lost_at_any_time_ends_no_patrol(seed: int) -> None:
    """More than 14 % are left, so the reserve is enough for the way to a dock."""
    chance = Random(seed)
    at_s, left, charge = (
        chance.uniform(8, 120),
        chance.uniform(0.14, 0.235),
        chance.uniform(0.25, 1),
    )
    flight = fly({"at_s": at_s, "battery": {"charge": left}}, charge=charge)
    assert lowest(flight, at_s + 110.0) > 100 * left - 2
    assert not flight.companion.has_ended, text(flight)
    assert flight.simulation.collisions == 0 and {*flight.places[-4:]} >= {"A", "B"}


@pytest.fixture
def soon_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """A dock that does not charge, or too slowly, is left after 15 s, not two or four minutes."""
    monkeypatch.setattr(landing, "NO_CHARGE_S", 15.0)
    monkeypatch.setattr(landing, "SLOW_WINDOWS", 1)


@pytest.mark.long
@pytest.mark.usefixtures("soon_given_up")
@pytest.mark.parametrize("tries", [1, 2])
def test_where_no_dock_charges_it_stays_on_the_first_one_with_the_reserve(tries: int) -> None:
    """It has arrived with what that one asks for: no other place, nor another try, is in reach."""
    given = two_docks()
    recharge = given["skills"]["recharge"] | {"tries": tries}
    mission = load_mission(given | {"skills": given["skills"] | {"recharge": recharge}})
    flight = fly(mission=mission, pads=[])
    flight.until(lambda: flight.companion.has_ended, 400.0)
    assert [e.belief for e in flight.of(BeliefWithdrawn)] == ["canCharge(E)"]
    assert flight.exit_code == 3 and not flight.simulation.is_armed
    assert percent(flight) >= RESERVE
    assert flight.places[-1] == "E" and flight.armings == 1, text(flight)


@pytest.mark.long
@pytest.mark.usefixtures("soon_given_up")
def test_it_stays_on_its_only_dock_too_if_the_skill_has_flown_there_itself() -> None:
    """The task has the vehicle between places then; its position says that it stands on W."""
    given = two_docks(patience_s=1.0, sets={"Place": ["Home", "A", "B", "W", "E"], "Pad": ["W"]})
    given["skills"]["recharge"] |= {
        "parameters": {"from": "Place", "pad": "Pad"},
        "precondition": "at(from)",
        "effect": "at(pad) & !at(from)",
        "execute": ["fly(pad)", "land()", "charge(auto)", "take_off()"],
    }
    flight = fly(mission=load_mission(given), pads=[])
    flight.until(lambda: flight.companion.has_ended, 400.0)
    assert [e.belief for e in flight.of(BeliefWithdrawn)] == ["canCharge(W)"]
    assert flight.exit_code == 3 and not flight.simulation.is_armed
    assert flight.armings == 1, text(flight)


def test_a_charge_of_a_skill_that_flies_to_its_dock_is_told_as_done() -> None:
    given = two_docks()
    given["skills"]["recharge"] |= {
        "parameters": {"from": "Place", "pad": "Pad"},
        "precondition": "at(from)",
        "effect": "at(pad) & !at(from)",
        "execute": ["fly(pad)", "land()", "charge(auto)", "take_off()"],
    }
    flight = fly(mission=load_mission(given))
    flight.until_reported(SkillCompleted, limit_s=300.0)
    assert flight.one(SkillCompleted).action.startswith("recharge(")
    assert all(event.action.startswith("move(") for event in flight.of(PlaceReached))


@pytest.mark.long
@pytest.mark.usefixtures("soon_given_up")
def test_on_a_dock_that_fails_under_it_with_the_floor_it_waits_and_goes_on() -> None:
    mission = load_mission(two_docks(patience_s=600))
    broken = [{**pad, "works": False} for pad in PADS]
    works = {"at_s": 90, "pad": {"name": "E", "works": True}}
    flight = fly(works, mission=mission, pads=broken)
    flight.until_reported(ChargeAwaited)
    flight.until_reported(SkillCompleted, limit_s=200.0, action="recharge(E)")
    assert lowest(flight, 30.0) >= RESERVE and not flight.companion.has_ended
    assert len(flight.of(ChargeAwaited)) == 1 and flight.of(ChargeAwaited)[0].patience_s == 600
    assert not flight.of(BeliefWithdrawn) and not flight.of(NoPlanFound), text(flight)


@pytest.mark.long
@pytest.mark.usefixtures("soon_given_up")
def test_a_dock_that_charges_at_less_than_half_its_rate_is_left_for_another() -> None:
    """As soon as the charge lasts for that."""
    slow = [{**PADS[0]}, {**PADS[1], "current_a": 10}]
    flight = fly(pads=slow)
    flight.until_reported(BeliefWithdrawn, limit_s=300.0)
    flight.until_reported(SkillCompleted, limit_s=200.0, action="recharge(W)")
    assert [e.belief for e in flight.of(BeliefWithdrawn)] == ["canCharge(E)"]
    assert "recharge(E) failed: the battery charges too slowly, it is at 2" in text(flight)
    assert not flight.of(ChargeAwaited) and not flight.of(NoPlanFound), text(flight)
    assert lowest(flight, 20.0) >= RESERVE


@pytest.mark.long
@pytest.mark.usefixtures("soon_given_up")
def test_where_all_docks_are_slow_the_second_one_is_stayed_on() -> None:
    flight = fly(pads=[{**pad, "current_a": 10} for pad in PADS])
    flight.until_reported(SkillCompleted, limit_s=600.0, action="recharge(W)")
    assert [e.belief for e in flight.of(BeliefWithdrawn)] == ["canCharge(E)"]
    assert lowest(flight, 20.0) >= RESERVE and not flight.of(NoPlanFound), text(flight)


@pytest.mark.usefixtures("soon_given_up")
def test_a_gauge_that_is_not_read_any_more_ends_the_task_with_the_reserve() -> None:
    mission = load_mission(two_docks(patience_s=15))
    flight = fly({"at_s": 18, "battery": {"known": False}}, mission=mission)
    flight.until(lambda: flight.companion.has_ended, 400.0)
    assert flight.exit_code == 3 and not flight.simulation.is_armed
    assert percent(flight) >= RESERVE
    assert "the battery does not charge, it is at unknown" in text(flight)


@pytest.mark.long
@pytest.mark.parametrize("away_s", [0.5, 4.0])
def test_one_that_is_cut_off_in_a_lap_goes_on(away_s: float) -> None:
    flight = fly(has_station=True, resumes=True)
    flight.until_reported(PlaceReached, place="B").run(1.0)
    flight.kill()
    flight.run(away_s)
    flight.restart()
    flight.until_reported(ControlTakenBack)
    assert lowest(flight, 40.0) >= RESERVE
    assert charges(flight) >= 2 and not flight.of(NoPlanFound), text(flight)
    assert all(each.used_wh < 2 * each.expected_wh for each in flight.of(EnergyUsed)), text(flight)


@pytest.mark.long
def test_after_a_pilots_flight_it_reckons_with_what_is_left() -> None:
    flight = fly(
        {"at_s": 30, "battery": {"charge": 0.235}}, charge=0.5, has_station=True, resumes=True
    )
    flight.until_reported(PlaceReached, place="B").run(1.0)
    flight.station_chooses("AUTO.LOITER")
    flight.until(lambda: flight.now_s > 35.0)
    flight.station_commands(CONTINUE, 1.0, component=COMPANION)
    flight.until_reported(ControlRegained)
    assert lowest(flight, 35.0) >= RESERVE - 0.2
    assert flight.of(VehicleLanded) and not flight.of(NoPlanFound), text(flight)


@pytest.mark.long
def test_patience_ends_when_the_charge_is_needed() -> None:
    """A door may open again; it waits as long as it can still land with the reserve."""
    skills = two_docks()["skills"]
    skills["move"] |= {"precondition": "at(from) & !closed"}
    events = {"closed": {"when": "EVENT[door] > 0"}}
    mission = load_mission(two_docks(skills=skills, events=events, patience_s=3000))
    flight = fly({"at_s": 24, "report": {"door": 1}}, charge=0.27, mission=mission)
    flight.until(lambda: flight.companion.has_ended, 600.0)
    assert flight.of(PlanAwaited) and flight.exit_code == 3, text(flight)
    assert flight.now_s > 60.0 and RESERVE - 0.2 <= percent(flight) < RESERVE + 3


LEGS = {"Home": (0, 0, 5), "A": (100, 0, 5), "B": (100, 80, 20), "C": (10, 10, 5)}


@pytest.mark.long
@pytest.mark.parametrize("east_mps", [0.0, 5.0])
def test_flights_take_what_plans_reckon_with(east_mps: float) -> None:
    """Level, climbing and descending, in still air, and with, across and against a wind."""
    places = {
        name: dict(zip(("east_m", "north_m", "up_m"), position, strict=True))
        for name, position in LEGS.items()
    }
    fence = [[-20, -20], [150, -20], [150, 150], [-20, 150]]
    skills = {"move": two_docks()["skills"]["move"]}
    mission = load_mission(
        two_docks(
            limits={"speed_mps": 5, "up_m": [1, 30], "fence": fence},
            battery={"reserve": RESERVE, "wind": {"east_mps": east_mps}},
            places=places,
            sets={"Place": list(places)},
            skills=skills,
            task={"go": "F (at(A) & F (at(B) & F at(C))) & F G at(Home)"},
        )
    )
    gusts = {"east_mps": east_mps, "turbulence_mps": 0.3 if east_mps else 0.0}
    flight = Lockstep(mission, world_of(mission, {"version": 1, "wind": gusts}), seed=1)
    flight.until_reported(PhaseEntered, phase=Phase.TASK)
    planned = sum(action.drain for action in Planner(mission).plan().prefix) / UNITS_PER_WH
    used_wh = 0.0
    while not flight.of(PlaceReached, place="Home"):
        flight.tick()
        state = flight.simulation.flight
        used_wh += state.voltage_v * state.current_a * TICK_S / 3600
    assert 0.95 * planned <= used_wh <= planned


@pytest.mark.long
def test_equal_seeds_equal_events() -> None:
    flights = [fly({"at_s": 18, "battery": {"charge": 0.235}}).run_for(30.0) for _ in range(2)]
    first, second = ([(s.time_s, s.event) for s in flight.reports] for flight in flights)
    assert first == second


def test_without_a_battery_plans_are_as_they_were() -> None:
    plain = two_docks()
    del plain["battery"]
    plain["skills"]["recharge"] |= {"execute": ["land()", "charge(80)", "take_off()"]}
    del plain["skills"]["recharge"]["charge_rate"]
    planner = Planner(load_mission(plain))
    problem, _ = planner.initial_problem()
    assert problem.energy is None and planner.energy is None
    assert not any(action.drain or action.charger for action in problem.actions)
    (found,) = Search(problem.actions).solutions(problem)
    assert planner.plan() == found
    assert str(found) == "move(Home, A), (move(A, B), move(B, A))^w"


def test_with_a_battery_for_everything_a_task_that_ends_has_the_same_plan() -> None:
    ends = two_docks(task={"visit": "F at(A) & F at(B) & F G at(Home)"})
    plan = Planner(load_mission(ends)).plan()
    assert str(plan) == "move(Home, A), move(A, B), move(B, Home), (wait)^w"
    assert replace(plan, lasso=plan.lasso).cost_ms == 100
