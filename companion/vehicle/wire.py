"""Decodes what arrives for component 191 and packs what it sends: bytes to messages and back.

This is the only place that decodes incoming messages. Both the vehicle's side (`offboard.py`) and
the ground stations' side (`ground/component.py`) read them.

1. The system id is that of the first autopilot heard. Earlier messages are dropped, and nothing is
   sent before.
2. Only messages that somebody has asked for are decoded; of continual ones, only the newest.
3. There is one sequence of numbers, whichever of the two sides sends.
4. The autopilot's questions for the time are answered at once, by `answers`, and only once.

Source: https://mavlink.io/en/services/heartbeat.html. No I/O: `link.py` moves the bytes.
"""

from __future__ import annotations

from companion.mavlink.framing import MavlinkCodec, Message, choose, dialect, message_of, source
from companion.vehicle.time_answers import TIMESYNC, TimeAnswers

COMPONENT = dialect.MAV_COMP_ID_ONBOARD_COMPUTER
AUTOPILOT = dialect.MAV_COMP_ID_AUTOPILOT1
_TIMESYNC_BYTE = bytes(TIMESYNC)
"""Its id, as a byte: a datagram without this byte contains no such message."""


class Wire:
    """The receiver and sender of component 191.

    Attributes:
        time: answers the autopilot's questions for the time.
        wanted: ids of the messages that are decoded.
        continual: of these, the messages of which only the newest of a tick is decoded.
    """

    def __init__(self) -> None:
        self.time = TimeAnswers()
        self._answered: list[bytes] = []
        self._codec = MavlinkCodec(0, COMPONENT)
        self.wanted: frozenset[int] = frozenset()
        self.continual: frozenset[int] = frozenset()
        self._telling: frozenset[int] = frozenset()

    @property
    def system(self) -> int:
        """The vehicle's system id, and our own; 0 until an autopilot was heard."""
        return self._codec.system

    def listen(
        self,
        wanted: frozenset[str],
        continual: frozenset[str],
        telling: frozenset[str] = frozenset(),
    ) -> None:
        """Sets what to decode from now on, by names of messages.

        Args:
            wanted: all that somebody reads; heartbeats are always included.
            continual: those of which only the newest of a tick counts.
            telling: those that may contain an event of the mission.
        """
        self.wanted = _ids(wanted | {"HEARTBEAT"})
        self.continual = _ids(continual)
        self._telling = _ids(telling)

    def parse(self, datagrams: list[bytes]) -> list[Message]:
        """The messages of a tick, in order, from and for any component."""
        frames = choose(datagrams, self.wanted, self.continual)
        messages = [message_of(frame) for frame in frames]
        if self.system:
            return messages
        for at, message in enumerate(messages):
            if is_autopilot(message):
                self._codec = MavlinkCodec(source(message)[0], COMPONENT)
                return messages[at:]
        return []

    def peek(self, datagrams: list[bytes]) -> list[Message]:
        """The messages that may contain an event; `parse` returns them again."""
        frames = choose(datagrams, self._telling, frozenset())
        return [message_of(frame) for frame in frames]

    def answers(self, now_s: float, datagrams: list[bytes]) -> list[bytes]:
        """What to send at once in answer to what arrives, without a step; nothing twice."""
        asking = [datagram for datagram in datagrams if _TIMESYNC_BYTE in datagram]
        frames = choose(asking, TIMESYNC, frozenset())
        return self.answer(now_s, [message_of(frame) for frame in frames])

    def answer(self, now_s: float, messages: list[Message]) -> list[bytes]:
        """The same for messages that are decoded already."""
        if not self.system:
            return []
        autopilot, leaving = (self.system, AUTOPILOT), []
        for message in messages:
            is_asking = message.get_type() == "TIMESYNC"
            if is_asking and (answer := self.time.answer(now_s, autopilot, message)):
                leaving.append(self._codec.pack(answer))
        self._answered += leaving
        return leaving

    def take_answered(self) -> list[bytes]:
        """What was sent at once since the last call; it also goes into the record of the flight."""
        answered, self._answered = self._answered, []
        return answered

    def pack(self, messages: list[Message]) -> list[bytes]:
        """A datagram for each message; none before the system id is known."""
        return [self._codec.pack(m) for m in messages] if self.system else []


def _ids(names: frozenset[str]) -> frozenset[int]:
    return frozenset(n for n, kind in dialect.mavlink_map.items() if kind.msgname in names)


def is_autopilot(message: Message) -> bool:
    """Whether a message is the HEARTBEAT of an autopilot; a decoded frame has a valid checksum."""
    return bool(
        message.get_type() == "HEARTBEAT"
        and message.get_srcComponent() == AUTOPILOT
        and message.autopilot != dialect.MAV_AUTOPILOT_INVALID
    )
