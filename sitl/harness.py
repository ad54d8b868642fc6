"""Simulator and companion in lockstep in one process: as fast as the machine, deterministic.

Both are state machines over time and datagrams, so they need neither sockets nor a clock. Each
step lasts one tick of the companion; what one side sends arrives at the other in the next step.
"""

from __future__ import annotations

from companion.acting.flight import TICK_S
from companion.app import Companion
from companion.errors import LinkTimeout
from sitl.link.routing import LinkName
from sitl.simulation import Simulation


def fly_in_lockstep(companion: Companion, simulation: Simulation, timeout_s: float = 30.0) -> None:
    """Flies until the companion has ended.

    Raises:
        LinkTimeout: no vehicle was heard in time (simulated seconds).
    """
    tick = 0
    to_vehicle: list[tuple[LinkName, bytes]] = []
    while not companion.has_ended:
        now_s = tick * TICK_S
        from_vehicle = simulation.step(now_s, to_vehicle)
        heard = [datagram for link, datagram in from_vehicle if link is LinkName.OFFBOARD]
        to_vehicle = [(LinkName.OFFBOARD, d) for d in companion.step(now_s, heard)]
        if companion.is_waiting and now_s > timeout_s:
            raise LinkTimeout(
                f"the simulated vehicle was not heard in {timeout_s:.0f} s of its time\n"
                "    does the simulation have the link to the companion?"
            )
        tick += 1
