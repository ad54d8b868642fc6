"""How well are the shipped missions planned and flown? One flight each, seed 0."""

from __future__ import annotations

import gc
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from statistics import median
from time import perf_counter

from benches import Row, timed
from benches.shipped import shipped
from companion.acting.report import Report
from companion.app import Companion
from companion.geometry import Ned, distance
from companion.ground.operations import Standing
from companion.mavlink.framing import Endpoint, split_frames
from companion.mission.model import Mission
from companion.mission_run import Recorder
from companion.planning.planner import Planner
from sitl.simulation import Simulation

SETPOINT = bytes([84, 0, 0])  # id of SET_POSITION_TARGET_LOCAL_NED, in bytes 7 to 9 of a frame


@dataclass
class Tracking:
    """A recorder of where the vehicle is told to be, and where it truly is.

    Attributes:
        gaps_m: from the newest setpoint to the vehicle, once per tick of the task in OFFBOARD, so
            not while a plan lands the vehicle.
        clearances_m: from the vehicle's centre to what is truly nearest, once per tick.
    """

    simulation: Simulation
    gaps_m: list[float] = field(default_factory=list)
    clearances_m: list[float] = field(default_factory=list)
    is_on_task: bool = False
    setpoint: Ned | None = None
    ear: Endpoint = field(default_factory=lambda: Endpoint(0, 0))

    def report(self, report: Report) -> None:
        """The task lasts until something else is flown than its plan."""
        if report.kind == "phase":
            self.is_on_task = report.text.startswith(("flying the task", "returning"))

    def packets(self, now_s: float, datagrams: list[bytes]) -> None:
        """Hears the setpoints."""
        for datagram in datagrams:
            for frame in split_frames(datagram):
                if frame[7:10] == SETPOINT:
                    for message in self.ear.parse(frame):
                        self.setpoint = (message.x, message.y, message.z)

    def position(self, now_s: float, position: Ned) -> None:
        """Takes the truth of this tick."""
        truth = self.simulation.flight.position
        assert self.simulation.true_map is not None
        self.clearances_m.append(self.simulation.true_map.clearance_m(truth[:2]))
        is_followed = self.is_on_task and self.simulation.mode == "OFFBOARD"
        if is_followed and self.setpoint is not None:
            self.gaps_m.append(distance(self.setpoint, truth))


class Stopwatch(Companion):
    """Takes the time of its steps while it has the vehicle.

    Args:
        ticks_s: where the times go.
    """

    def __init__(self, ticks_s: list[float], mission: Mission, recorder: Recorder) -> None:
        super().__init__(mission, recorder)
        self._ticks_s = ticks_s

    def step(self, now_s: float, datagrams: list[bytes]) -> list[bytes]:
        """One tick."""
        start_s = perf_counter()
        packets = super().step(now_s, datagrams)
        if self.standing is Standing.ACTIVE:
            self._ticks_s.append(perf_counter() - start_s)
        return packets


def planning(runs: int) -> Iterator[Row]:
    """The search for the first plan; the way between places is known."""
    for path in sorted({flight.mission: flight for flight in shipped()}.values(), key=str):
        mission = path.load()
        took = timed(Planner(mission).plan, max(3, runs // 5))
        yield Row(f"{mission.name}: first plan", median(took), "ms")


def flying(runs: int) -> Iterator[Row]:
    """Setpoint against vehicle, and the room that was left, the same each time; what ticks take."""
    for flight in shipped():
        ticks_s: list[float] = []
        mission = flight.load()
        gc.collect()
        gc.freeze()  # as before any flight by the clock
        seen = flight.fly(mission, Tracking, companion=partial(Stopwatch, ticks_s))
        gc.unfreeze()
        assert isinstance(seen, Tracking)
        square = sum(gap_m**2 for gap_m in seen.gaps_m) / len(seen.gaps_m)
        yield Row(f"{flight.name}: gap to setpoint, RMS", 100 * math.sqrt(square), "cm")
        yield Row(f"{flight.name}: gap to setpoint, worst", 100 * max(seen.gaps_m), "cm")
        yield Row(f"{flight.name}: least clearance", 100 * min(seen.clearances_m), "cm")
        yield Row(f"{flight.name}: slowest tick of {len(ticks_s)}", 1000 * max(ticks_s), "ms")
