"""What all components on board share: sequence numbers, answers, HEARTBEAT at 1 Hz.

A command that a component does not know is UNSUPPORTED.
"""

from __future__ import annotations

from typing import Protocol

from companion.mavlink.framing import MavlinkCodec, Message, dialect, source
from sitl.flight.physics import FlightState
from sitl.link.routing import target
from sitl.results import MavResult
from sitl.world.payload import CommandAck

HEARTBEAT_S = 1.0
COMMANDS = ("COMMAND_LONG", "COMMAND_INT")
_ONBOARD_CONTROLLER, _NO_AUTOPILOT, _ACTIVE = 18, 8, 4

PackedMessage = tuple[Message, bytes]
"""A message and its frame."""


class OnboardComponent(Protocol):
    """A component on board."""

    address: tuple[int, int]

    def receive(self, message: Message, state: FlightState) -> list[PackedMessage]:
        """Handles any message; returns what is sent at once."""

    def step(self, state: FlightState) -> list[PackedMessage]:
        """The messages that are due now."""


class ComponentSender:
    """Packs messages and keeps time for what repeats.

    Args:
        address: system and component of the sender.
    """

    def __init__(self, address: tuple[int, int]) -> None:
        self._codec = MavlinkCodec(*address)
        self._next_s: dict[float, float] = {}

    def pack(self, message: Message) -> PackedMessage:
        """Packs a message with its frame."""
        return message, self._codec.pack(message)

    def is_due(self, every_s: float, now_s: float) -> bool:
        """Whether a message with this period is due now."""
        next_s = self._next_s.get(every_s, now_s)
        if now_s < next_s:
            return False
        self._next_s[every_s] = next_s + every_s
        return True

    def acknowledge(self, command: int, reply: CommandAck) -> PackedMessage:
        """COMMAND_ACK to the sender of a command."""
        return self.pack(
            dialect.MAVLink_command_ack_message(
                command, reply.result, reply.progress, 0, *reply.requester
            )
        )

    def refuse(self, message: Message, address: tuple[int, int]) -> list[PackedMessage]:
        """UNSUPPORTED for any command."""
        if message.get_type() not in COMMANDS or target(message) != address:
            return []
        return [
            self.acknowledge(message.command, CommandAck(source(message), MavResult.UNSUPPORTED)),
        ]

    def heartbeat(self, now_s: float, kind: int = _ONBOARD_CONTROLLER) -> list[PackedMessage]:
        """HEARTBEAT with a MAV_TYPE, when it is due."""
        if not self.is_due(HEARTBEAT_S, now_s):
            return []
        return [self.pack(dialect.MAVLink_heartbeat_message(kind, _NO_AUTOPILOT, 0, 0, _ACTIVE, 3))]
