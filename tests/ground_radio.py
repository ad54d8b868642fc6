"""Component 191 on a wire with an autopilot and ground stations, and the desk of its operators."""

from __future__ import annotations

from typing import Any

from autopilot import Autopilot, of_type

from companion.ground.component import WANTED, Component
from companion.ground.operations import SystemStatus
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mission.signals import Signal
from companion.outcomes import Refusal
from companion.tick import TICK_S
from companion.vehicle.wire import Wire

STATION = (255, 190)


class Desk:
    """Where operators' wishes arrive; it says no if it has a reason."""

    def __init__(self) -> None:
        self.system_status = SystemStatus.STANDBY
        self.awaited = frozenset({"MAV_CMD_USER_1"})
        self.asked: list[str] = []
        self.refusal: Refusal | None = None

    def start(self) -> Refusal | None:
        return self._note("start")

    def pause(self) -> Refusal | None:
        return self._note("pause")

    def resume(self) -> Refusal | None:
        return self._note("resume")

    def return_home(self) -> Refusal | None:
        return self._note("return home")

    def _note(self, what: str) -> Refusal | None:
        self.asked.append(what)
        return self.refusal


class Radio:
    """The component on a wire with an autopilot that was heard, and ground stations."""

    def __init__(self) -> None:
        self.desk = Desk()
        self.component = Component(self.desk)
        self.now_s = 0.0
        self.readings: list[tuple[Signal, float]] = []
        self._wire = Wire()
        self._wire.listen(WANTED, frozenset())
        self._wire.parse(Autopilot().telemetry())
        self._ear = MavlinkCodec(0, 0)

    def raw(self, *datagrams: bytes) -> list[Any]:
        """One tick; what left, as messages."""
        self.now_s += TICK_S
        messages = self._wire.parse(list(datagrams))
        self.readings = self.component.receive(self.now_s, self._wire.system, messages)
        leaving = self.component.transmit(self.now_s)
        self.unknown = [m for m in leaving if m.id not in dialect.mavlink_map]
        sent = [m for d in self._wire.pack(leaving) for m in self._ear.parse(d)]
        for message in sent:
            message.left_s = self.now_s
        return sent

    def say(self, *messages: Any, sender: tuple[int, int] = STATION) -> list[Any]:
        return self.raw(*(MavlinkCodec(*sender).pack(m) for m in messages))

    def run(self, seconds: float) -> list[Any]:
        return [m for _ in range(round(seconds / TICK_S)) for m in self.raw()]

    def ask(self, number: int, *parameters: float, target: tuple[int, int] = (1, 191)) -> list[Any]:
        return self.say(command(number, *parameters, target=target))

    def result(self, number: int, *parameters: float) -> int:
        (answer,) = of_type(self.ask(number, *parameters), "COMMAND_ACK")
        assert answer.command == number
        assert (answer.target_system, answer.target_component) == STATION
        return int(answer.result)


def command(number: int, *parameters: float, target: tuple[int, int] = (1, 191)) -> Any:
    filled = (*parameters, *[0.0] * (7 - len(parameters)))
    return dialect.MAVLink_command_long_message(*target, number, 0, *filled)
