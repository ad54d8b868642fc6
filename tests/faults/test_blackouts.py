"""Nothing is heard, in either direction, for a time: the same actions, and no command meanwhile."""

from __future__ import annotations

from functools import cache

import pytest
from campaign import actions, shipped, sweep, undisturbed, world
from lockstep import Cut, Lockstep

from companion.acting.sortie.authority import LINK_LOST_S
from companion.errors import LinkError
from companion.flight_events.event import FlightEvent
from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import ControlTakenBack, Phase, PhaseEntered, ReturnedAsAsked
from companion.vehicle.heard_time import QUIET_S

pytestmark = pytest.mark.faults

SURVEILLANCE = "surveillance"
PHASES = (Phase.TAKE_OFF, Phase.OFFBOARD, Phase.TASK, Phase.RETURNING, Phase.LANDING)
BLACKOUTS_S = (1.0, 3.0, 10.0, 60.0)
INTO_S = 0.4
"""From the begin of a phase; entering OFFBOARD takes little more than a second."""
CALLED_HOME_S = 25.0


def blackout(phase: Phase, silent_s: float, into_s: float = INTO_S) -> Lockstep:
    """A flight, in which nothing is heard for a time in a phase, to its end."""
    air = Cut()
    mission, hall = shipped(SURVEILLANCE), world(SURVEILLANCE)
    flight = Lockstep(mission, hall, up=air, down=air, resumes=True)
    if phase is Phase.RETURNING:
        flight.run(CALLED_HOME_S)
        assert flight.companion.return_home() is None
    flight.until_reported(PhaseEntered, phase=phase).run(into_s)
    begun_s, air.is_cut = flight.now_s, silent_s > 0.0
    flight.run(silent_s)
    air.is_cut = False
    quiet = [c for c in flight.commands if begun_s + QUIET_S < c.time_s <= begun_s + silent_s]
    assert quiet == []
    return flight.until(lambda: flight.companion.has_ended)


def done(flight: Lockstep) -> list[FlightEvent | str]:
    """What was done, in order; a plan that begins between places leads to the same ones."""
    return [e.place if isinstance(e, PlaceReached) else e for e in actions(flight)]


@cache
def without(phase: Phase) -> list[FlightEvent | str]:
    is_called_home = phase is Phase.RETURNING
    return done(blackout(phase, 0.0) if is_called_home else undisturbed(SURVEILLANCE))


@pytest.mark.parametrize(
    ("phase", "silent_s"),
    sweep(PHASES, BLACKOUTS_S, few=lambda phase, silent_s: False),
)
def test_a_blackout_changes_no_action(phase: Phase, silent_s: float) -> None:
    """In each phase in the air, with `--resume`: it goes on by the rule of resume."""
    flight = blackout(phase, silent_s)
    assert flight.exit_code == 0
    assert done(flight) == without(phase)
    assert flight.armings == 1 and flight.simulation.collisions == 0


@pytest.mark.parametrize(
    ("into_s", "silent_s"),
    sweep([0.05 * i for i in range(40)], (1.5, 3.0, 10.0), few=lambda *_: False),
)
def test_a_blackout_at_any_time_around_offboard(into_s: float, silent_s: float) -> None:
    """Before the command, after it, where OFFBOARD begins unheard, and after it was heard."""
    flight = blackout(Phase.OFFBOARD, silent_s, into_s)
    assert flight.exit_code == 0
    assert done(flight) == without(Phase.OFFBOARD)
    assert flight.armings == 1 and flight.simulation.collisions == 0


def test_on_the_way_home_it_goes_on_home() -> None:
    flight = blackout(Phase.RETURNING, 10.0)
    assert flight.of(ControlTakenBack) != [] and flight.ending == ReturnedAsAsked()


def test_on_the_ground_before_arming_the_link_is_given_up() -> None:
    air = Cut()
    flight = Lockstep(shipped(SURVEILLANCE), world(SURVEILLANCE), up=air, down=air, resumes=True)
    flight.until_reported(PhaseEntered, phase=Phase.CHECKING)
    air.is_cut, cut_s = True, flight.now_s
    flight.until(lambda: flight.companion.has_ended)
    assert flight.exit_code == LinkError.exit_code
    assert flight.now_s - cut_s == pytest.approx(LINK_LOST_S, abs=0.2)
    assert flight.armings == 0
