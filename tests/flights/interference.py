"""Flights with which somebody or something interferes, for test_safety.py and test_link_loss.py."""

from __future__ import annotations

import math
from collections.abc import Callable

from lockstep import Lockstep

from companion.errors import Aborted
from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import RunFailed

Start = Callable[..., Lockstep]


def on_the_way_to_b(flight: Lockstep) -> Lockstep:
    """In the middle of the task, at full speed."""
    flight.until_reported(PlaceReached, place="A").run(2.0)
    assert math.hypot(*flight.simulation.flight.velocity) > 1.0
    return flight


def aborted(reason: str) -> RunFailed:
    return RunFailed(reason, Aborted.exit_code)


def flown_modes(flight: Lockstep) -> list[str]:
    return [mode for _, mode in flight.modes]
