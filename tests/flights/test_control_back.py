"""How soon control is back once both keys are there: by the simulator's time, from the later one.

The vehicle is the simulator's, and so is the mode that counts: it flies OFFBOARD again. The keys
are those of `companion/acting/sortie/authority.py`.
"""

from __future__ import annotations

from collections.abc import Callable
from random import Random

import meadow
import pytest
from lockstep import COMPANION, Cut, Lockstep, World

from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import (
    FlightFoundAgain,
    Phase,
    PhaseEntered,
    SetpointRefused,
    VehicleLanded,
)
from companion.mavlink.framing import dialect
from companion.mission.loader import load_mission
from companion.mission.model import Mission

BACK_S = 5.0
OURS, HOLD = "OFFBOARD", "AUTO.LOITER"
TAKE_OFF = dialect.MAV_CMD_NAV_TAKEOFF
HEARD_S = 2.0
"""After this the companion has heard of a mode: a heartbeat comes once a second."""
CAMPAIGN = (pytest.mark.faults, pytest.mark.long)
SEEDS = [0, *(pytest.param(seed, marks=CAMPAIGN) for seed in range(1, 40))]

Keys = Callable[[Lockstep, Cut, Random], float]
"""Has control be lost, and turns the keys; returns when the later one was turned."""


def mode_since_s(flight: Lockstep, mode: str) -> float:
    since_s, flown = flight.modes[-1]
    assert flown == mode
    return since_s


def operator_says_continue(flight: Lockstep) -> float:
    """The pilot, or the autopilot, holds already."""
    flight.run(HEARD_S)
    mode_since_s(flight, HOLD)
    flight.station_commands(dialect.MAV_CMD_DO_PAUSE_CONTINUE, 1.0, component=COMPANION)
    return flight.now_s


def restarted(flight: Lockstep, away_s: float) -> float:
    """Killed, and another one begins after a time."""
    flight.kill()
    flight.run(away_s)
    flight.restart()
    return flight.now_s


def pilot_hands_over(flight: Lockstep, air: Cut, chance: Random) -> float:
    """A return climbs, and where the mission does not fly control is not taken back."""
    chosen = chance.choice(["AUTO.RTL", "AUTO.LOITER", "POSCTL"])
    flight.station_chooses(chosen)
    flight.run(chance.uniform(0.5, 0.7 if chosen == "AUTO.RTL" else 4.0))
    flight.station_chooses(HOLD)
    flight.run(chance.uniform(0.0, 2.0))
    return operator_says_continue(flight)


def link_comes_back(flight: Lockstep, air: Cut, chance: Random) -> float:
    """`--resume` is the other key: the autopilot holds because it no longer heard us."""
    air.is_cut = True
    flight.run(chance.uniform(2.0, 10.0))
    air.is_cut = False
    return max(flight.now_s, mode_since_s(flight, HOLD))


def killed_and_restarted_before_the_hold(flight: Lockstep, air: Cut, chance: Random) -> float:
    """The autopilot holds a second after the last setpoint; the next one says nothing before."""
    restarted(flight, chance.uniform(0.1, 0.8))
    flight.until(lambda: flight.simulation.mode == HOLD, 3.0).tick()
    return mode_since_s(flight, HOLD)


def killed_and_restarted_in_the_hold(flight: Lockstep, air: Cut, chance: Random) -> float:
    restarted_s = restarted(flight, chance.uniform(1.5, 8.0))
    assert mode_since_s(flight, HOLD) < restarted_s
    return restarted_s


def killed_and_the_operator_is_asked(flight: Lockstep, air: Cut, chance: Random) -> float:
    """A pilot has held meanwhile, so that `--resume` is no key."""
    flight.kill()
    flight.run(chance.uniform(0.1, 0.8))
    flight.station_chooses(HOLD)
    flight.run(chance.uniform(0.5, 4.0))
    flight.restart()
    flight.until_reported(FlightFoundAgain)
    return operator_says_continue(flight)


KEYS: dict[str, Keys] = {
    keys.__name__: keys
    for keys in (
        pilot_hands_over,
        link_comes_back,
        killed_and_restarted_before_the_hold,
        killed_and_restarted_in_the_hold,
        killed_and_the_operator_is_asked,
    )
}
FEW = {pilot_hands_over.__name__, killed_and_restarted_before_the_hold.__name__}
"""Flown in every run; a restart in the hold is, too, by tests/flights/test_resume.py."""


def in_flight(mission: Mission, world: World, seed: int, begin_s: float) -> tuple[Lockstep, Cut]:
    """Some time after the first place."""
    air = Cut()
    flight = Lockstep(
        mission, world, seed=seed, up=air, down=air, has_station=True, resumes=True
    ).until_reported(PlaceReached, place="A")
    flight.run(begin_s)
    return flight, air


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(
    "keys",
    [
        pytest.param(keys, marks=[] if name in FEW else [pytest.mark.long], id=name)
        for name, keys in KEYS.items()
    ],
)
def test_control_is_back_five_seconds_after_the_later_key(
    surveillance: Mission, short_hall: World, keys: Keys, seed: int
) -> None:
    chance = Random(seed)
    flight, air = in_flight(surveillance, short_hall, seed, chance.uniform(0.0, 15.0))
    turned_s = keys(flight, air, chance)
    assert flight.simulation.mode == HOLD
    flight.until(lambda: flight.simulation.mode == OURS, 20.0).tick()
    assert 0.0 < mode_since_s(flight, OURS) - turned_s <= BACK_S
    assert flight.armings == 1


@pytest.mark.parametrize("above_m", [pytest.param(0.2, marks=pytest.mark.long), 0.9])
def test_a_vehicle_that_is_given_back_above_its_altitudes_comes_down_and_flies_on(
    above_m: float,
) -> None:
    """At the highest of them it flies over the wall: where it is, it may not."""
    wall = {"east_m": [40, 41], "north_m": [-12, 12], "up_m": 3}
    fence = [[-9, -9], [70, -9], [70, 9], [-9, 9]]
    limits = {"speed_mps": 4, "up_m": [1, 6], "fence": fence}
    places = meadow.DATA["places"] | {"A": {"east_m": 60, "north_m": 0, "up_m": 3}}
    about = {
        "places": places,
        "limits": limits,
        "map": {"walls": [wall]},
        "task": {"go": "F at(A)"},
    }
    flight = meadow.start(load_mission(meadow.DATA | about), resumes=True)
    flight.until(lambda: flight.simulation.flight.position[1] > 10.0)
    flight.station_chooses("AUTO.RTL")
    flight.until(lambda: -flight.simulation.flight.position[2] > 5.8 + above_m)
    flight.station_chooses(HOLD)
    flight.run(4.0)
    assert 0.0 < -flight.simulation.flight.position[2] - 6.0 < 1.0
    continued_s = operator_says_continue(flight)
    flight.until_reported(PlaceReached, place="A")
    assert flight.now_s - continued_s < 30.0 and not flight.of(SetpointRefused)


@pytest.mark.parametrize(
    "mode", [pytest.param("AUTO.LAND", marks=pytest.mark.long), "AUTO.TAKEOFF"]
)
def test_who_is_taken_over_in_a_landing_by_the_plan_needs_no_take_off(mode: str) -> None:
    """Given back in the air the vehicle is in OFFBOARD, and flies on from there."""
    flight = meadow.start(meadow.stay("land()", "take_off()"), resumes=True)
    flight.until_reported(PlaceReached, place="A")
    flight.until(lambda: flight.simulation.mode == mode).run(2.0)
    flight.station_chooses(HOLD)
    flight.run(HEARD_S)
    operator_says_continue(flight)
    flight.until(lambda: flight.simulation.mode == OURS)
    climbs = [said.message.command for said in flight.commands].count(TAKE_OFF)
    flight.run(2.0)
    assert flight.simulation.mode == OURS
    assert [said.message.command for said in flight.commands].count(TAKE_OFF) == climbs
    assert flight.until_the_end().exit_code == 0


@pytest.mark.long
@pytest.mark.parametrize("after_s", [0.5, 3.0, 4.5])
def test_killed_in_a_take_off_by_the_plan_it_is_told_that_an_operator_is_waited_for(
    after_s: float,
) -> None:
    """The autopilot climbs to its end and holds, without any loss of setpoints."""
    flight = meadow.start(meadow.stay("land()", "take_off()"), resumes=True)
    flight.until_reported(VehicleLanded)
    flight.until(lambda: flight.simulation.mode == "AUTO.TAKEOFF").run(after_s)
    restarted(flight, 1.0)
    flight.until_reported(FlightFoundAgain).run(10.0)
    key = flight.one(FlightFoundAgain).key
    assert key.endswith("is flown: hold, then continue, to give control back")
    assert flight.simulation.mode == HOLD
    operator_says_continue(flight)
    assert flight.until_the_end().exit_code == 0


def test_and_so_it_is_after_a_kill_in_the_take_off(
    surveillance: Mission, short_hall: World
) -> None:
    """The autopilot climbs to its end and holds; an operator is asked."""
    flight = Lockstep(surveillance, short_hall, has_station=True, resumes=True)
    flight.until_reported(PhaseEntered, phase=Phase.TAKE_OFF).run(1.0)
    restarted(flight, 1.0)
    flight.until(lambda: flight.simulation.mode == HOLD, 20.0)
    turned_s = operator_says_continue(flight)
    flight.until(lambda: flight.simulation.mode == OURS, 20.0).tick()
    assert 0.0 < mode_since_s(flight, OURS) - turned_s <= BACK_S
