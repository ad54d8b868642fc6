"""The reports of a mission's progress.

MISSION_ITEM_REACHED is sent at once for every item reached. The last one is repeated ten times,
once a second, because nobody acknowledges it (as in PX4). MISSION_CURRENT is sent at once when
another item becomes current; it is also a stream.
"""

from __future__ import annotations

from companion.mavlink.framing import Message, dialect
from sitl.link.messages import compose
from sitl.link.vehicle import SimulatedVehicle

REPETITIONS = 10
REPEAT_S = 1.0


class MissionProgressReporter:
    """The reports of one vehicle's mission."""

    def __init__(self) -> None:
        self._current = 0
        self._reached = 0
        self._repetitions = 0
        self._next_s = 0.0

    def due(self, vehicle: SimulatedVehicle) -> list[Message]:
        """The messages to send now, on every link."""
        mission, now_s = vehicle.autopilot.mission, vehicle.state.time_s
        messages = []
        if mission.reached:
            messages = [dialect.MAVLink_mission_item_reached_message(i) for i in mission.reached]
            self._reached = mission.reached[-1]
            self._repetitions, self._next_s = REPETITIONS, now_s + REPEAT_S
            mission.reached.clear()
        elif self._repetitions and now_s >= self._next_s:
            self._repetitions -= 1
            self._next_s += REPEAT_S
            messages = [dialect.MAVLink_mission_item_reached_message(self._reached)]
        if mission.current != self._current:
            self._current = mission.current
            messages.append(compose("MISSION_CURRENT", vehicle))
        return messages
