"""A companion that is cut off in flight, and another one that goes on: what is sent, and when.

The simulated vehicle holds, as PX4 does with COM_OBL_RC_ACT 5, once the stream of setpoints is
lost.
"""

from __future__ import annotations

import pytest
from lockstep import Lockstep, World

from companion.flight_events.skills import PlaceReached, SkillCompleted
from companion.flight_events.sortie import (
    ControlTakenBack,
    FlightFoundAgain,
    TaskSatisfied,
)
from companion.mavlink.framing import dialect
from companion.mission.model import Mission

CONTINUE = dialect.MAV_CMD_DO_PAUSE_CONTINUE
BACK_S = 5.0
"""From the last key to control."""


def actions(flight: Lockstep) -> list[str]:
    """What was done, in order, but for flights between sites, which are begun again."""
    return [e.action for e in flight.of(SkillCompleted)]


@pytest.fixture
def flight(surveillance: Mission, hall: World) -> Lockstep:
    return Lockstep(surveillance, hall, has_station=True, goes_on=True)


def kill(flight: Lockstep, away_s: float = 3.0) -> None:
    flight.kill()
    flight.run(away_s)
    flight.restart()


def test_a_companion_that_was_killed_goes_on(flight: Lockstep) -> None:
    flight.until_reported(PlaceReached, place="A").run(2.0)
    sent = len(flight.said)
    kill(flight)
    flight.until_reported(FlightFoundAgain).until_reported(ControlTakenBack)
    since = [said.message.get_type() for said in flight.said[sent:]]
    assert "SET_POSITION_TARGET_LOCAL_NED" not in since and "COMMAND_LONG" not in since
    flight.until_the_end()
    assert flight.ending == TaskSatisfied() and flight.armings == 1
    assert actions(flight) == ["upload(r1)", "upload(r2)"][-len(actions(flight)) :]
    assert flight.places[0] == "A"
