"""A mission acted out by a FakeVehicle, tick by tick: no MAVLink, no physics, no take-off."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from fakes import FakeVehicle
from happened import Happened

from companion.acting.assembly import assemble
from companion.acting.event_detector import EventDetector
from companion.acting.executive_states import TaskStatus
from companion.acting.preparation import prepare
from companion.acting.safe_places import flight_to
from companion.flight_events.event import FlightEvent, Stamped
from companion.flight_events.word import PositionLeft
from companion.mission.model import Mission
from companion.mission.signals import Signal
from companion.motion.layered_routes import LayeredRoutes
from companion.planning.engine_port import Engine
from companion.planning.lasso import Lasso
from companion.tick import TICK_S


class Rig(Happened):
    """Everything that acts, wired as in `companion.app`.

    Args:
        mission: what to do.
        routes: its routes; made if absent.
        vehicle: the vehicle; in the air at home if absent.
        engine: who plans; the built-in search if absent.

    Attributes:
        acting: its parts.
        reports: what happened so far, as people are told.
        positions: the positions of the word that were left.
        left_s: when each of them was.
        plans: every plan so far.
    """

    def __init__(
        self,
        mission: Mission,
        routes: LayeredRoutes | None = None,
        vehicle: FakeVehicle | None = None,
        engine: Engine | None = None,
    ) -> None:
        home = mission.home
        self.mission = mission
        self.vehicle = vehicle or FakeVehicle(home.position).take_off(-home.position[2])
        prepared = prepare(mission, routes=routes, engine=engine)
        self.acting = acting = assemble(prepared, self.vehicle, EventDetector(mission.events))
        self.planner = prepared.planner
        self.flight, self.executive = acting.flight, acting.executive
        self.task, self.speed_limit = acting.flight.task, acting.flight.speed_limit
        self.reports: list[Stamped] = []
        self.positions: list[PositionLeft] = []
        self.left_s: list[float] = []
        self.plans: list[Lasso] = []
        self._ticks = 0

    def begin(self) -> Rig:
        """Makes the first plan."""
        failure = self.executive.plan()
        assert failure is None, str(failure)
        self._collect()
        return self

    def pass_time(self) -> None:
        """One tick passes for the vehicle and the clock; nothing acts."""
        self._ticks += 1
        self.flight.now_s = self._ticks * TICK_S
        self.speed_limit.advance(self.flight.now_s)
        self.vehicle.step(self.flight.now_s)

    def tick(self, *readings: tuple[Signal, float]) -> TaskStatus:
        """One tick, in the order of `Sortie.step`."""
        self.pass_time()
        self.acting.perception.take(readings)
        self.flight.guidance.brake()
        status = self.executive.tick()
        self._collect()
        return status

    def leave_for(self, place: str) -> bool:
        """Leaves for a safe place, as without a plan; false if no route leads there."""
        lasso = flight_to(self.planner, place)
        if lasso is not None:
            self.executive.leave(lasso)
        return lasso is not None

    def run(self, until: Callable[[], bool], limit_s: float = 120.0) -> None:
        """Ticks until a condition holds; the test fails if it takes too long."""
        for _ in range(round(limit_s / TICK_S)):
            if until():
                return
            self.tick()
        told = "\n".join(event.text for event in self.events)
        raise AssertionError(f"not reached in {limit_s:.0f} s:\n{told}")

    def run_until(self, kind: type[FlightEvent], times: int = 1, **fields: Any) -> None:
        """Ticks until an event has happened a number of times."""
        self.run(lambda: len(self.of(kind, **fields)) >= times)

    def run_to_the_end(self) -> TaskStatus:
        """Ticks until the task is satisfied or has no plan."""
        self.run(lambda: self.executive.status is not TaskStatus.RUNNING)
        return self.executive.status

    def _collect(self) -> None:
        lasso = self.executive.lasso
        if lasso is not None and (not self.plans or lasso is not self.plans[-1]):
            self.plans.append(lasso)
        for stamped in self.flight.collect_reports():
            if stamped.event.is_told:
                self.reports.append(stamped)
            if isinstance(stamped.event, PositionLeft):
                self.positions.append(stamped.event)
                self.left_s.append(stamped.time_s)
