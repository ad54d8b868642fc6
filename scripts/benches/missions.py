"""The quality of plans and flights of the shipped missions; one flight each, seed 0."""

from __future__ import annotations

import gc
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from statistics import median
from time import thread_time

from benches import Row, timed
from benches.shipped import shipped
from companion.acting.journal import Journal, NoJournal
from companion.app import Companion
from companion.flight_events.event import Stamped
from companion.flight_events.sortie import Phase, PhaseEntered, ReturnBegun
from companion.geometry import Ned, distance
from companion.ground.operations import SystemStatus
from companion.mavlink.framing import MavlinkCodec, split_frames
from companion.planning.planner import Planner
from companion.tick import TICK_S
from companion.vehicle.run_clocks import ClockReading
from sitl.simulation import Simulation

SETPOINT = bytes([84, 0, 0])  # id of SET_POSITION_TARGET_LOCAL_NED, in bytes 7 to 9 of a frame


@dataclass
class Tracking:
    """A recorder of the setpoints and of the vehicle's true positions.

    Attributes:
        gaps_m: from the newest setpoint to the vehicle, once per tick of the task in OFFBOARD, so
            not while a plan lands the vehicle.
        told_mps: speed of the newest setpoint.
        velocities: the true velocity at that time, and the time.
        clearances_m: from the vehicle's centre to the nearest true obstacle, once per tick.
    """

    simulation: Simulation | None = None
    gaps_m: list[float] = field(default_factory=list)
    velocities: list[tuple[float, Ned]] = field(default_factory=list)
    clearances_m: list[float] = field(default_factory=list)
    is_on_task: bool = False
    setpoint: Ned | None = None
    told_mps: float = 0.0
    ear: MavlinkCodec = field(default_factory=lambda: MavlinkCodec(0, 0))
    journal: Journal = field(default_factory=NoJournal)
    name: str = ""

    def report(self, stamped: Stamped) -> None:
        """Ends the task when anything but its plan is flown."""
        match stamped.event:
            case PhaseEntered(phase=phase):
                self.is_on_task = phase in (Phase.TASK, Phase.RETURNING)
            case ReturnBegun():
                self.is_on_task = True
            case event if event.kind == PhaseEntered.kind:
                self.is_on_task = False

    def clocks(self, reading: ClockReading) -> None:
        """Ignores the clocks."""

    def packets(self, now_s: float, datagrams: list[bytes]) -> None:
        """Reads the setpoints."""
        for datagram in datagrams:
            for frame in split_frames(datagram):
                if frame[7:10] == SETPOINT:
                    for message in self.ear.parse(frame):
                        self.setpoint = (message.x, message.y, message.z)
                        self.told_mps = math.hypot(message.vx, message.vy, message.vz)

    def position(self, now_s: float, position: Ned) -> None:
        """Takes the true state of this tick."""
        assert self.simulation is not None and self.simulation.true_map is not None
        truth = self.simulation.flight.position
        self.clearances_m.append(self.simulation.true_map.clearance_m(truth[:2]))
        is_followed = self.is_on_task and self.simulation.mode == "OFFBOARD"
        is_followed = is_followed and self.simulation.is_armed
        if is_followed and self.setpoint is not None:
            self.gaps_m.append(distance(self.setpoint, truth))
            self.velocities.append((now_s, self.simulation.flight.velocity))

    @property
    def speed_mps(self) -> float:
        """The highest true speed."""
        return max(math.hypot(*velocity) for _, velocity in self.velocities)

    @property
    def acceleration_mps2(self) -> float:
        """The highest true acceleration, over two ticks."""
        pairs = zip(self.velocities, self.velocities[2:], strict=False)
        over_s = 2 * TICK_S
        return max(distance(a, b) / over_s for (s, a), (t, b) in pairs if t - s < 1.1 * over_s)


def timed_steps(companion: Companion) -> list[float]:
    """CPU seconds of each step of a companion from now on, with its vehicle."""
    ticks_s: list[float] = []
    step = companion.step

    def timed_step(
        now_s: float, datagrams: list[bytes], is_tick: bool = True, reports: Sequence[bytes] = ()
    ) -> list[bytes]:
        start_s = thread_time()
        packets = step(now_s, datagrams, is_tick, reports)
        if companion.system_status is SystemStatus.ACTIVE:
            ticks_s.append(thread_time() - start_s)
        return packets

    companion.step = timed_step  # type: ignore[method-assign]
    return ticks_s


def planning(runs: int) -> Iterator[Row]:
    """The search for the first plan, with known routes between places."""
    for each in sorted({each.mission: each for each in shipped()}.values(), key=str):
        mission = each.load()
        planner = Planner(mission)
        solve = partial(planner.solver.solve, *planner.initial_problem())
        took = timed(solve, max(3, runs // 5))
        yield Row(f"{mission.name}: first plan", median(took), "ms")


def flying(runs: int) -> Iterator[Row]:
    """Setpoint against vehicle, and the room left, always the same; and the duration of ticks."""
    for each in shipped():
        mission, seen = each.load(), Tracking()
        flight = each.flight(mission, seen)
        seen.simulation, ticks_s = flight.simulation, timed_steps(flight.companion)
        gc.collect()
        gc.freeze()  # as before any flight by the clock
        flight.fly()
        gc.unfreeze()
        square = sum(gap_m**2 for gap_m in seen.gaps_m) / len(seen.gaps_m)
        yield Row(f"{each.name}: gap to setpoint, RMS", 100 * math.sqrt(square), "cm")
        yield Row(f"{each.name}: gap to setpoint, worst", 100 * max(seen.gaps_m), "cm")
        limits = mission.speed_limits
        yield Row(f"{each.name}: duration", flight.now_s, "s")
        yield Row(
            f"{each.name}: greatest speed", 100 * seen.speed_mps / limits.speed_mps, "% of limit"
        )
        share = seen.acceleration_mps2 / limits.acceleration_mps2
        yield Row(f"{each.name}: greatest acceleration", 100 * share, "% of limit")
        yield Row(f"{each.name}: least clearance", 100 * min(seen.clearances_m), "cm")
        yield Row(f"{each.name}: slowest tick of {len(ticks_s)}", 1000 * max(ticks_s), "ms")
