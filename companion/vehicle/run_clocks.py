"""Records what the clocks of a run show: when it begins, when the vehicle arms, and when it ends.

PX4 begins a log when the vehicle is armed. So then its clock is compared with ours, and the log is
marked with the run. A mission that lands on its way arms again, and so has another log.
"""

from __future__ import annotations

from typing import NamedTuple

from companion.vehicle.boot_clock import ClockOffset
from companion.vehicle.telemetry import Telemetry
from companion.vehicle.wire import Wire


class ClockReading(NamedTuple):
    """What the clocks showed at one time.

    Attributes:
        occasion: why they were read.
        time_s: since the run began.
        clock_s: the machine's monotonic clock; None in lockstep.
        autopilot: when the autopilot's clock showed 0, counted from the start of the run; None
            before it has answered.
    """

    occasion: str
    time_s: float
    clock_s: float | None
    autopilot: ClockOffset | None


class RunClocks:
    """The clocks of one run.

    Args:
        wire: answers the autopilot's questions for our time.
        telemetry: has the autopilot's clock.

    Attributes:
        has_armed: the vehicle was first heard to be armed in this step.
    """

    def __init__(self, wire: Wire, telemetry: Telemetry) -> None:
        self._wire, self._telemetry = wire, telemetry
        self.has_armed = self._is_armed = self._has_begun = self._is_due = False

    def follow(self, is_armed: bool) -> None:
        """Begins a step."""
        self.has_armed, self._is_armed = is_armed and not self._is_armed, is_armed
        self._is_due = is_armed and (self._is_due or self.has_armed)

    def due(self, now_s: float, start_s: float, has_ended: bool) -> list[ClockReading]:
        """The readings to record in this step; that of arming waits until the autopilot's clock is
        known.

        Args:
            now_s: the flight's time.
            start_s: when the run began.
            has_ended: whether this is the run's last step.
        """
        begins, self._has_begun = not self._has_begun, True
        if not (begins or self._is_due or has_ended):
            return []
        zero_s, offset = self._wire.time.zero_s, self._telemetry.clock.offset
        is_armed = self._is_due and offset is not None
        self._is_due = self._is_due and not is_armed
        occasions = {"start": begins, "armed": is_armed, "end": has_ended}
        if offset is not None:
            offset = offset._replace(offset_s=offset.offset_s - start_s)
        clock_s = zero_s + now_s if zero_s is not None else None
        return [
            ClockReading(occasion, now_s - start_s, clock_s, offset)
            for occasion, is_now in occasions.items()
            if is_now
        ]
