"""A client of the simulator without sockets: sends messages, hears what comes back and when."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

from companion.mavlink.framing import (
    MavlinkCodec,
    dialect,
    is_intact,
    message_id,
    message_of,
    split_frames,
)
from companion.mavlink.px4_modes import MODES, mode_name
from companion.motion.grid import OccupancyGrid
from sitl.link.routing import LinkName
from sitl.simulation import Simulation
from sitl.world.scenario import Scenario

NAN = float("nan")
POSITION_MASK = 0xDF8  # SET_POSITION_TARGET_LOCAL_NED: position only
VELOCITY_MASK = 0xDC7
STEP_S = 0.004


@dataclass(frozen=True)
class Heard:
    """A frame that was heard; few of them are looked into, which takes as long as a step."""

    time_s: float
    link: LinkName
    frame: bytes

    @cached_property
    def message(self) -> Any:
        return message_of(self.frame)

    @cached_property
    def name(self) -> str:
        return str(dialect.mavlink_map[message_id(self.frame)].msgname)


class Wire:
    """One component at the end of one link."""

    def __init__(
        self,
        scenario: Scenario | None = None,
        grid: OccupancyGrid | None = None,
        *,
        link: LinkName = LinkName.OFFBOARD,
        address: tuple[int, int] = (1, 191),
    ) -> None:
        self.simulation = Simulation(scenario or Scenario(), grid, seed=1)
        self.link = link
        self.codec = MavlinkCodec(*address)
        self.heard: list[Heard] = []
        self.frames: list[bytes] = []
        self.now_s = 0.0
        self._step = 0

    def send(self, *messages: Any) -> None:
        """Deliver messages now; no time passes."""
        self._exchange([(self.link, self.codec.pack(message)) for message in messages])

    def run(
        self, seconds: float, each_s: float = 0.02, send: Callable[[], Any] | None = None
    ) -> None:
        """Let time pass; with `send`, deliver what it makes every `each_s`."""
        every = max(1, round(each_s / STEP_S))
        for i in range(round(seconds / STEP_S)):
            if send and i % every == 0:
                self.send(send())
            self._step += 1
            self.now_s = self._step * STEP_S
            self._exchange([])

    def run_until(self, is_done: Callable[[], bool], limit_s: float, **stream: Any) -> float:
        """Let time pass until something holds; how long it took."""
        start_s = self.now_s
        while not is_done():
            assert self.now_s - start_s < limit_s, f"not within {limit_s} s"
            self.run(0.02, **stream)
        return self.now_s - start_s

    def command(self, number: int, *parameters: float, component: int = 1) -> list[int]:
        """Send a COMMAND_LONG and give it 20 ms; the results of its answers."""
        before = len(self.heard)
        filled = (*parameters, *(0.0,) * (7 - len(parameters)))
        self.send(dialect.MAVLink_command_long_message(1, component, number, 0, *filled))
        self.run(0.02)
        return [
            heard.message.result
            for heard in self.heard[before:]
            if heard.name == "COMMAND_ACK"
            and heard.message.command == number
            and heard.link is self.link
        ]

    def set_mode(self, name: str) -> list[int]:
        return self.command(dialect.MAV_CMD_DO_SET_MODE, 1, *MODES[name])

    def arm(self, on: bool = True, magic: float = 0) -> list[int]:
        return self.command(dialect.MAV_CMD_COMPONENT_ARM_DISARM, float(on), magic)

    def named(self, name: str, link: LinkName | None = None) -> list[Heard]:
        """What was heard of one message on a link, ours by default."""
        return [h for h in self.heard if h.name == name and h.link is (link or self.link)]

    def last(self, name: str) -> Any:
        return self.named(name)[-1].message

    def mode_changes(self) -> list[tuple[float, str | None]]:
        """When the autopilot's HEARTBEAT told of another mode."""
        told = [
            (h.time_s, mode_name(h.message.custom_mode))
            for h in self.named("HEARTBEAT")
            if h.message.get_srcComponent() == 1
        ]
        return [now for i, now in enumerate(told) if i == 0 or told[i - 1][1] != now[1]]

    def texts(self, link: LinkName | None = None) -> list[str]:
        return [h.message.text for h in self.named("STATUSTEXT", link)]

    def setpoint(
        self, north: float, east: float, down: float, *, frame: int = 1, mask: int = POSITION_MASK
    ) -> Any:
        """Position, or with VELOCITY_MASK velocity."""
        return dialect.MAVLink_set_position_target_local_ned_message(
            0, 1, 1, frame, mask, *(north, east, down) * 3, 0.0, 0.0
        )

    def fly_offboard(self, north: float, east: float, down: float) -> None:
        """Arm, take off and hover at a point in OFFBOARD; the stream ends afterwards."""
        send = partial(self.setpoint, north, east, down)
        self.run(0.1, send=send)
        self.set_mode("OFFBOARD")
        assert self.arm() == [0]
        self.run_until(
            lambda: abs(self.simulation.flight.position[2] - down) < 0.2, 20.0, send=send
        )
        self.run(2.0, send=send)

    def _exchange(self, datagrams: list[tuple[LinkName, bytes]]) -> None:
        for link, frame in self.simulation.step(self.now_s, datagrams):
            self.frames.append(frame)
            intact = filter(is_intact, split_frames(frame))
            self.heard += [Heard(self.now_s, link, each) for each in intact]


def gcs_heartbeat() -> Any:
    return dialect.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)


def companion_heartbeat() -> Any:
    return dialect.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3)
