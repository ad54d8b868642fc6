"""Watches where the frames lie: tells when the autopilot's moves, and when it is in doubt for long.

While it is in doubt the task is frozen and the gate holds the vehicle where it is, which is right
in any frame. It goes on when both positions of the autopilot agree again.
"""

from __future__ import annotations

from companion.acting.flight import Flight
from companion.acting.phases import ON_THE_GROUND, UNDER_TASK
from companion.errors import Aborted
from companion.flight_events.frames import FrameDoubted, FrameTrusted, OriginMoved
from companion.flight_events.sortie import Phase
from companion.geometry import GlobalOrigin, distance

TOLD_S = 0.5
"""A doubt that lasts no longer is not told: one of two messages was late."""
LOST_S = 10.0
"""After this a vehicle in the air is landed; one on the ground does not begin."""
FROZEN = (*ON_THE_GROUND, Phase.ARMING, Phase.TAKE_OFF, Phase.OFFBOARD, *UNDER_TASK)
"""Phases that go on only in a frame that is certain; the others need none."""


class FrameWatch:
    """The watch of one sortie.

    Args:
        flight: of the vehicle.
    """

    def __init__(self, flight: Flight) -> None:
        self._flight = flight
        self._origin: GlobalOrigin | None = None
        self._since_s: float | None = None
        self._is_told = False

    def step(self, phase: Phase) -> Aborted | None:
        """Looks at the frames, once a tick; why the sortie cannot go on, or None."""
        self._follow()
        flight, doubt = self._flight, self._flight.vehicle.frame_doubt
        if doubt is None or phase not in FROZEN:
            if self._is_told:
                flight.report(FrameTrusted())
            self._since_s, self._is_told = None, False
            return None
        if self._since_s is None:
            self._since_s = flight.now_s
        lasted_s = flight.now_s - self._since_s
        if lasted_s > TOLD_S and not self._is_told:
            self._is_told = True
            flight.report(FrameDoubted(doubt.reason))
        return Aborted(f"{doubt.reason}, for {LOST_S:.0f} s") if lasted_s > LOST_S else None

    def is_frozen(self, phase: Phase) -> bool:
        """Whether a phase has to wait."""
        return phase in FROZEN and self._flight.vehicle.frame_doubt is not None

    def _follow(self) -> None:
        there, before = self._flight.vehicle.origin, self._origin
        if there is None or there == before:
            return
        self._origin = there
        if before is not None:
            north, east, down = there.to_local(
                before.latitude_deg, before.longitude_deg, before.altitude_m
            )
            self._flight.report(OriginMoved(round(distance((north, east, down), (0, 0, 0)), 2)))
