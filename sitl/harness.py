"""Runs simulator and companion in lockstep in one process: fast and deterministic.

Both are state machines over time and datagrams, so they need neither sockets nor a clock. Each tick
is one tick of the companion. What one side sends arrives at the other in the next tick, except the
companion's immediate answers, which arrive at once, as they do in real time.
"""

from __future__ import annotations

from collections.abc import Iterator

from companion.app import Companion
from companion.errors import LinkTimeout
from companion.geometry import Ned
from companion.tick import TICK_S
from sitl.link.routing import LinkName
from sitl.simulation import Simulation


class LockstepFlight:
    """One companion on one simulated vehicle.

    Attributes:
        companion: stepped second in each tick.
        simulation: stepped first.
        truth: time and true position of the vehicle, for each tick.
    """

    def __init__(self, companion: Companion, simulation: Simulation) -> None:
        self.companion = companion
        self.simulation = simulation
        self.truth: list[tuple[float, Ned]] = []
        self._to_vehicle: list[tuple[LinkName, bytes]] = []
        self._ticks = 0

    @property
    def now_s(self) -> float:
        """Time of the next tick."""
        return self._ticks * TICK_S

    def tick(self) -> None:
        """One tick of both."""
        from_vehicle = self.simulation.step(self.now_s, self._to_vehicle)
        self.truth.append((self.now_s, self.simulation.flight.position))
        heard = [datagram for link, datagram in from_vehicle if link is LinkName.OFFBOARD]
        if answers := self.companion.wire.answers(self.now_s, heard):
            at_once = [(LinkName.OFFBOARD, answer) for answer in answers]
            from_vehicle = self.simulation.step(self.now_s, at_once)
            heard += [datagram for link, datagram in from_vehicle if link is LinkName.OFFBOARD]
        reports = self.simulation.take_reports()
        sent = self.companion.step(self.now_s, heard, reports=reports)
        self._to_vehicle = [(LinkName.OFFBOARD, datagram) for datagram in sent]
        self._ticks += 1

    def ticks(self, timeout_s: float = 30.0) -> Iterator[None]:
        """Ticks until the companion has ended; the caller may stop after any tick.

        Raises:
            LinkTimeout: no vehicle was heard in time (simulated seconds).
        """
        while not self.companion.has_ended:
            now_s = self.now_s
            self.tick()
            yield
            if now_s > timeout_s and (missing := self.companion.missing) is not None:
                raise LinkTimeout(
                    f"the simulated vehicle tells {missing} in {timeout_s:.0f} s of its time\n"
                    "    does the simulation have the link to the companion?"
                )

    def fly(self, timeout_s: float = 30.0) -> None:
        """Flies until the companion has ended and the vehicle is at rest.

        Raises:
            LinkTimeout: no vehicle was heard in time (simulated seconds).
        """
        for _ in self.ticks(timeout_s):
            pass
        self.simulation.settle()
