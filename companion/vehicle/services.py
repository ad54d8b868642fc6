"""The interface of the MAVLink services spoken besides flying: payloads, a fence, a marker.

`MavlinkVehicle` is composed of services. Each is a class in its own file, keeps its own state, and
offers the acting side what `ports/` declares. A service does no I/O: it takes messages and returns
those to send.

Rules, which the vehicle enforces for all services:
1. A service receives the messages that it names, from every component of the vehicle's system. It
   decides itself whom it believes, and whether a message is meant for us.
2. While control is not ours, or in doubt, a service that needs control sends nothing.
3. A service that is released starts anew: earlier requests are not sent any more, unless somebody
   makes them again.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from companion.mavlink.framing import Message


@dataclass(frozen=True, slots=True)
class Moment:
    """The time at which a service takes or sends something.

    Attributes:
        now_s: the time.
        heard_s: time in which the autopilot was heard (`heard_time.py`); waits for answers are
            counted in it.
        is_quiet: the autopilot is not heard now.
    """

    now_s: float
    heard_s: float
    is_quiet: bool


class Service(Protocol):
    """A service of one vehicle, for one flight."""

    @property
    def wanted(self) -> frozenset[str]:
        """Names of the messages that it receives."""

    @property
    def needs_control(self) -> bool:
        """Whether it sends nothing while control is not ours."""

    def step(self, moment: Moment) -> None:
        """Begins a tick, before any message is taken."""

    def take(self, moment: Moment, message: Message) -> None:
        """Takes a message of the vehicle's system that it wants."""

    def due(self, moment: Moment) -> list[Message]:
        """The messages to send now."""

    def release(self) -> None:
        """Stops all requests."""
