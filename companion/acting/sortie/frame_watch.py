"""Watches the frames: reports when the autopilot's frame moves, and when it is long in doubt.

While it is in doubt, the task is frozen and the gate holds the vehicle where it is, which is
correct in any frame. The task continues when both positions of the autopilot agree again.
"""

from __future__ import annotations

from companion.acting.flight import Flight
from companion.acting.sortie.phases import ON_THE_GROUND, UNDER_TASK
from companion.errors import Aborted
from companion.flight_events.frames import FrameDoubted, FrameTrusted, OriginMoved
from companion.flight_events.sortie import Phase
from companion.geometry import GlobalOrigin, distance

TOLD_S = 0.5
"""A shorter doubt is not reported: one of two messages was late."""
LOST_S = 10.0
"""After this time a vehicle in the air is landed, and one on the ground does not begin."""
FROZEN = (*ON_THE_GROUND, Phase.ARMING, Phase.TAKE_OFF, Phase.OFFBOARD, *UNDER_TASK)
"""The phases that continue only in a certain frame; the others need no frame."""


class FrameWatch:
    """The watch of one sortie.

    Args:
        flight: the flight.
    """

    def __init__(self, flight: Flight) -> None:
        self._flight = flight
        self._origin: GlobalOrigin | None = None
        self._since_s: float | None = None
        self._is_told = False

    def step(self, phase: Phase) -> Aborted | None:
        """Checks the frames, once a tick; returns why the sortie cannot continue, or None."""
        self._follow()
        flight, doubt = self._flight, self._flight.vehicle.frame.doubt
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
        """Whether a phase has to wait for a certain frame."""
        return phase in FROZEN and self._flight.vehicle.frame.doubt is not None

    def _follow(self) -> None:
        there, before = self._flight.vehicle.frame.origin, self._origin
        if there is None or there == before:
            return
        self._origin = there
        if before is not None:
            north, east, down = there.to_local(
                before.latitude_deg, before.longitude_deg, before.altitude_m
            )
            self._flight.report(OriginMoved(round(distance((north, east, down), (0, 0, 0)), 2)))
