"""Companion and simulator in one process, tick by tick, with a link that may fail in between.

As `sitl.harness`, but a test may stop at any tick, speak as a ground station, stop stepping the
companion, and put something between the two that loses, delays or doubles datagrams. What one
side sends arrives at the other in the next tick. Nothing here knows a clock.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from random import Random
from typing import Any, NamedTuple, Self

from happened import Happened
from kept_journal import KeptJournal

from companion.acting.function_port import FunctionPort
from companion.acting.journal import JournalledFlight, put_together
from companion.acting.sortie.preflight.arming_terms import USUAL_ARMING, ArmingTerms
from companion.acting.sortie.terms import SortieTerms
from companion.app import Companion
from companion.flight_events.event import FlightEvent, Stamped
from companion.flight_events.sortie import RunEnded, SetpointRefused
from companion.geometry import Ned
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mavlink.px4_modes import MODES
from companion.mavlink.signing import Signing
from companion.mission.model import Mission
from companion.motion.grid import OccupancyGrid
from companion.run_sources.only_run import OnlyRun
from companion.tick import TICK_S
from companion.vehicle.flight_memory import FlightMemory
from companion.vehicle.run_clocks import ClockReading
from sitl.link.routing import LinkName
from sitl.results import MavResult
from sitl.simulation import Simulation
from sitl.world.scenario import Scenario

World = tuple[Scenario, OccupancyGrid | None]
Air = Callable[[float, list[bytes]], list[bytes]]
"""What becomes of datagrams on their way: time and what was sent in, what arrives out."""

VEHICLE = 1
"""Its system id."""
COMPANION = 191
"""Its companion's component id."""
PAYLOAD = 25
"""Component id of the shipped missions' payloads."""
ASKING = (
    dialect.MAV_CMD_REQUEST_MESSAGE,
    dialect.MAV_CMD_REQUEST_CAMERA_CAPTURE_STATUS,
    dialect.MAV_CMD_RUN_PREARM_CHECKS,
)
SETPOINT = "SET_POSITION_TARGET_LOCAL_NED"


class Said(NamedTuple):
    """A message that left somebody, and when."""

    time_s: float
    message: Any


def clear(now_s: float, datagrams: list[bytes]) -> list[bytes]:
    """Everything arrives."""
    return datagrams


class Lossy:
    """Loses a share of all datagrams."""

    def __init__(self, share: float, seed: int) -> None:
        self._share = share
        self._random = Random(seed)

    def __call__(self, now_s: float, datagrams: list[bytes]) -> list[bytes]:
        return [d for d in datagrams if self._random.random() >= self._share]


class Jittery:
    """Every datagram comes up to 0.2 s late, so that they overtake each other; some come twice."""

    LATEST_S = 0.2

    def __init__(self, doubled: float, seed: int) -> None:
        self._doubled = doubled
        self._random = Random(seed)
        self._under_way: list[tuple[float, bytes]] = []

    def __call__(self, now_s: float, datagrams: list[bytes]) -> list[bytes]:
        for datagram in datagrams:
            for _ in range(1 + (self._random.random() < self._doubled)):
                arrival_s = now_s + self._random.uniform(0.0, self.LATEST_S)
                self._under_way.append((arrival_s, datagram))
        arrived = sorted(entry for entry in self._under_way if entry[0] <= now_s)
        self._under_way = [entry for entry in self._under_way if entry[0] > now_s]
        return [datagram for _, datagram in arrived]


class Cut:
    """Nothing arrives while `is_cut`."""

    def __init__(self) -> None:
        self.is_cut = False

    def __call__(self, now_s: float, datagrams: list[bytes]) -> list[bytes]:
        return [] if self.is_cut else datagrams


class Deaf:
    """Messages of one kind are lost while it is deaf."""

    def __init__(self, message_id: int) -> None:
        self.is_deaf = False
        self._header = message_id.to_bytes(3, "little")

    def __call__(self, now_s: float, datagrams: list[bytes]) -> list[bytes]:
        return [d for d in datagrams if not (self.is_deaf and d[7:10] == self._header)]


class AllButFinalAnswers:
    """Something on the way up that the payload's final answers pass untouched."""

    def __init__(self, air: Air) -> None:
        self._air = air

    def __call__(self, now_s: float, datagrams: list[bytes]) -> list[bytes]:
        safe = [d for d in datagrams if is_final_answer(d)]
        return self._air(now_s, [d for d in datagrams if d not in safe]) + safe


def is_final_answer(frame: bytes) -> bool:
    """COMMAND_ACK (id 77) of the payload, other than IN_PROGRESS; MAVLink 2 trims zeros."""
    is_payloads_ack = frame[6] == PAYLOAD and frame[7:10] == bytes([77, 0, 0])
    return is_payloads_ack and frame[12] != MavResult.IN_PROGRESS


class _Read:
    """What a flight's companion reads of the streams; the flight is the same without the rest.

    The ground station reads none. tests/flights/test_lockstep.py shows that it is the same.
    """

    def __init__(self, flight: Lockstep) -> None:
        self._flight = flight

    @property
    def wanted(self) -> frozenset[int]:
        return self._flight.companion.wire.wanted

    @property
    def continual(self) -> frozenset[int]:
        return self._flight.companion.wire.continual


class Lockstep(Happened):
    """One flight; it is also the recorder of its companion.

    Args:
        mission: what to do.
        world: scenario and true map.
        seed: of the simulator.
        up: the way from the vehicle to the companion.
        down: the way back.
        has_station: whether a ground station is there, with its heartbeat.
        resumes: as with `run --resume`.
        vehicle: signs and verifies what the simulator sends and hears.
        functions: what the mission's Python skills do.
        arming: on which terms the vehicle is armed.
        memory: of earlier flights.

    Attributes:
        companion: under test.
        is_companion_alive: whether it steps with every tick.
        reports: what the companion reported that people are told.
        recorded: all that it reported, which a run folder would have.
        said: what it sent, before the way to the vehicle.
        heard: what the ground station heard of it.
        acknowledged: every COMMAND_ACK that left the vehicle, before the way to the companion.
        modes: the modes that were flown, in order, with the time of the change.
        armings: how often the motors were started.
    """

    def __init__(
        self,
        mission: Mission,
        world: World,
        *,
        seed: int = 0,
        up: Air = clear,
        down: Air = clear,
        has_station: bool = False,
        resumes: bool = False,
        vehicle: Signing | None = None,
        functions: FunctionPort | None = None,
        arming: ArmingTerms = USUAL_ARMING,
        memory: FlightMemory | None = None,
    ) -> None:
        self.journal = KeptJournal()
        self.name = "the-run"
        self._terms = SortieTerms(arming, resumes=resumes)
        self._mission, self._memory, self._functions = mission, memory, functions
        scenario, grid = world
        links = {LinkName.OFFBOARD} | ({LinkName.GCS} if has_station else set())
        self.companion = self._companion(None)
        is_all_read = up is not clear or scenario.disturbs_links or vehicle is not None
        self.simulation = Simulation(
            scenario,
            grid,
            seed=seed,
            links=frozenset(links),
            signing=vehicle,
            reader=None if is_all_read else _Read(self),
        )
        self.is_companion_alive = True
        self.reports: list[Stamped] = []
        self.recorded: list[Stamped] = []
        self.said: list[Said] = []
        self.heard: list[Said] = []
        self.acknowledged: list[Said] = []
        self.modes: list[tuple[float, str]] = []
        self.armings = 0
        self._up, self._down = up, down
        self._station = MavlinkCodec(255, 190)
        self._has_station = has_station
        self._ear, self._vehicle_ear = MavlinkCodec(0, 0), MavlinkCodec(0, 0)
        self._station_ear = MavlinkCodec(0, 0)
        self._to_vehicle: list[tuple[LinkName, bytes]] = []
        self._was_armed = False
        self._ticks = 0

    def kill(self) -> None:
        """The companion is gone at once, with all that it knew."""
        self.is_companion_alive = False
        self._killed_s = self.now_s

    def restart(self) -> None:
        """Another companion begins, with the journal of the one before; time has gone on."""
        journalled = put_together(self.journal.entries)
        if journalled is not None:
            journalled = replace(journalled, away_s=self.now_s - journalled.time_s)
        self.companion = self._companion(journalled)
        self.is_companion_alive = True

    def _companion(self, journalled: JournalledFlight | None) -> Companion:
        only = OnlyRun(self._mission, self, functions=self._functions, journalled=journalled)
        return Companion(only, self._terms, memory=self._memory)

    # -- companion.mission_run.Recorder ---------------------------------------------------------

    def report(self, stamped: Stamped) -> None:
        """In no phase does a setpoint outlive who flies."""
        if isinstance(stamped.event, SetpointRefused):
            assert "not renewed" not in stamped.event.reason, stamped
        self.recorded.append(stamped)
        if stamped.event.is_told:
            self.reports.append(stamped)

    def clocks(self, reading: ClockReading) -> None:
        """Not read."""

    def packets(self, now_s: float, datagrams: list[bytes]) -> None:
        """Kept in `said`."""

    def position(self, now_s: float, position: Ned) -> None:
        """The truth is asked of the simulation."""

    # -- time ----------------------------------------------------------------------------------

    @property
    def now_s(self) -> float:
        """Time of the newest tick."""
        return (self._ticks - 1) * TICK_S

    def tick(self) -> None:
        """One tick of both sides."""
        now_s = self._ticks * TICK_S
        if self._has_station and self._ticks % round(1 / TICK_S) == 0:
            self.station_says(_station_heartbeat())
        arriving, self._to_vehicle = self._to_vehicle, []
        heard = self._watch(now_s, self.simulation.step(now_s, arriving))
        arrived = self._up(now_s, heard)
        if self.is_companion_alive:
            reports = self.reported(now_s)
            self.transmit(now_s, self.companion.step(now_s, arrived, reports=reports))
        self._ticks += 1

    def reported(self, now_s: float) -> list[bytes]:
        """What other programs on board report in a tick."""
        return self.simulation.take_reports()

    def transmit(self, now_s: float, sent: list[bytes]) -> None:
        """What the companion sends now; it arrives in the next tick."""
        self.said += [Said(now_s, m) for d in sent for m in self._ear.parse(d)]
        self._to_vehicle += [(LinkName.OFFBOARD, d) for d in self._down(now_s, sent)]

    def run(self, seconds: float) -> None:
        """Lets time pass."""
        for _ in range(round(seconds / TICK_S)):
            self.tick()

    def run_for(self, seconds: float) -> Self:
        """Lets time pass, in a chain of calls."""
        self.run(seconds)
        return self

    def until(self, is_so: Callable[[], bool], limit_s: float = 150.0) -> Self:
        """Lets time pass until something is so; the test fails if that takes too long."""
        for _ in range(round(limit_s / TICK_S)):
            if is_so():
                return self
            self.tick()
        told = "\n".join(event.text for event in self.events)
        raise AssertionError(f"not in {limit_s:.0f} s:\n{told}")

    def until_reported(
        self, kind: type[FlightEvent], limit_s: float = 150.0, **fields: Any
    ) -> Self:
        """Lets time pass until an event is reported."""
        return self.until(lambda: self.of(kind, **fields) != [], limit_s)

    def until_the_end(self, limit_s: float = 150.0) -> Self:
        """Lets time pass until the companion has ended."""
        return self.until(lambda: self.companion.has_ended, limit_s)

    # -- what happened -------------------------------------------------------------------------

    @property
    def ending(self) -> RunEnded:
        """The last event, which must be the end."""
        assert isinstance(self.events[-1], RunEnded), self.events
        return self.events[-1]

    @property
    def exit_code(self) -> int:
        """Of the end."""
        return self.ending.exit_code

    @property
    def setpoints(self) -> list[Said]:
        """The setpoints that the companion sent."""
        return [s for s in self.said if s.message.get_type() == SETPOINT]

    @property
    def commands(self) -> list[Said]:
        """The commands that the companion sent, but for those that only ask."""
        sent = [s for s in self.said if s.message.get_type() == "COMMAND_LONG"]
        return [s for s in sent if s.message.command not in ASKING]

    # -- the ground station --------------------------------------------------------------------

    def station_says(self, message: Any) -> None:
        """The ground station sends a message."""
        assert self._has_station
        self._to_vehicle.append((LinkName.GCS, self._station.pack(message)))

    def station_commands(self, command: int, *parameters: float, component: int = 1) -> None:
        """The ground station sends a command, to the autopilot if to nobody else."""
        filled = (*parameters, *[0.0] * (7 - len(parameters)))
        self.station_says(
            dialect.MAVLink_command_long_message(VEHICLE, component, command, 0, *filled)
        )

    def station_chooses(self, mode: str) -> None:
        """The pilot switches to a mode."""
        self.station_commands(dialect.MAV_CMD_DO_SET_MODE, 1.0, *MODES[mode])

    def _watch(self, now_s: float, sent: list[tuple[LinkName, bytes]]) -> list[bytes]:
        """Notes what the vehicle does; returns what it sent towards the companion."""
        heard = [datagram for link, datagram in sent if link is LinkName.OFFBOARD]
        for link, datagram in sent:
            if link is LinkName.GCS and datagram[6] == COMPANION:
                self.heard += [Said(now_s, m) for m in self._station_ear.parse(datagram)]
        for datagram in heard:
            if datagram[7:10] == bytes([77, 0, 0]):  # the id of COMMAND_ACK
                self.acknowledged += [Said(now_s, m) for m in self._vehicle_ear.parse(datagram)]
        if not self.modes or self.modes[-1][1] != self.simulation.mode:
            self.modes.append((now_s, self.simulation.mode))
        is_armed = self.simulation.is_armed
        self.armings += is_armed and not self._was_armed
        self._was_armed = is_armed
        return heard


def _station_heartbeat() -> Any:
    return dialect.MAVLink_heartbeat_message(
        dialect.MAV_TYPE_GCS, dialect.MAV_AUTOPILOT_INVALID, 0, 0, dialect.MAV_STATE_ACTIVE, 3
    )
