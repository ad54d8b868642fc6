"""The form of a MAVLink service that is spoken beside the flying: payloads, a fence, a marker.

`MavlinkVehicle` composes its services: each is a class in a file of its own that keeps its own
state, and offers the acting side what `port.py` says of it. A service does no I/O: it takes
messages and hands out those to send.

Rules, which the vehicle holds all services to:
1. A service takes the messages that it names, of every component of the vehicle's system; whom it
   believes, and whether a message is meant for us, it says itself.
2. While control is not ours, or in doubt, one that needs control says nothing.
3. What is released begins anew: nothing that was asked for before is sent any more, unless
   somebody asks for it again.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from companion.mavlink.framing import Message


@dataclass(frozen=True, slots=True)
class Moment:
    """When a service takes or says something.

    Attributes:
        now_s: the time.
        heard_s: the time in which the autopilot was heard (`heard_time.py`); what waits for an
            answer counts in it.
        is_quiet: the autopilot is not heard now.
    """

    now_s: float
    heard_s: float
    is_quiet: bool


class Service(Protocol):
    """A service of one vehicle, for one flight."""

    @property
    def wanted(self) -> frozenset[str]:
        """Names of the messages that it takes."""

    @property
    def needs_control(self) -> bool:
        """Whether it says nothing while control is not ours."""

    def step(self, moment: Moment) -> None:
        """Time has passed; once a tick, before anything is taken."""

    def take(self, moment: Moment, message: Message) -> None:
        """Takes a message of the vehicle's system that it wants."""

    def due(self, moment: Moment) -> list[Message]:
        """What it has to say now."""

    def release(self) -> None:
        """Asks for nothing any longer."""
