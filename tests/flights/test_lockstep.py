"""The yardstick of all flights: what nobody reads is not packed, and the flight is the same."""

from __future__ import annotations

import pytest
from lockstep import Air, Lockstep, World, clear

from companion.flight_events.event import Stamped
from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import ControlTakenBack
from companion.mission.model import Mission


def all_of(now_s: float, datagrams: list[bytes]) -> list[bytes]:
    """A way that might lose something: so all of the streams take it."""
    return datagrams


def killed_on_the_way(mission: Mission, world: World, up: Air) -> tuple[list[Stamped], bytes]:
    """What was told, and what was sent, until the next companion has control back."""
    flight = Lockstep(mission, world, up=up, has_station=True, resumes=True)
    flight.until_reported(PlaceReached, place="A").run(2.0)
    flight.kill()
    flight.run(3.0)
    flight.restart()
    flight.until_reported(ControlTakenBack).run(2.0)
    return flight.recorded, b"".join(bytes(said.message.get_msgbuf()) for said in flight.said)


@pytest.mark.long
def test_a_flight_is_the_same_where_only_what_is_read_is_sent(
    surveillance: Mission, hall: World
) -> None:
    """Also that of a companion that goes on after another one."""
    one, other = (killed_on_the_way(surveillance, hall, up) for up in (clear, all_of))
    assert one == other
