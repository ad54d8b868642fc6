"""Remembers where other runs of the program laid the frames of missions in metres, per autopilot.

The first sortie lays the mission's frame where its vehicle stands (mission_frame.py); later sorties
keep it. After a landing the vehicle stands up to a metre beside home. A program that starts then
would lay the frame there, and all walls with it. So it continues with the earlier frame for as long
as the autopilot's local frame stays the same: until the autopilot restarts.

An autopilot is recognized by its system id and its boot time. The boot time is computed with the
computer's own clock, which is passed in here; neither users nor the network may set it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from companion.vehicle.mission_frame import LaidHome, MissionFrame

SAME_BOOT_S = 10.0
"""Two estimates of one boot time differ by less: clocks drift apart by 100 parts per million for a
day, or by 2 %, as that of a simulated autopilot on a busy machine, for eight minutes between two
sorties. Between two boots lies more time: a flight."""
MOST_FRAMES = 16
"""The newest ones are remembered."""


@dataclass(frozen=True, slots=True)
class LaidFrame:
    """A frame that was laid.

    Attributes:
        system: MAVLink system id of the vehicle.
        booted_s: when its autopilot booted, by the computer's clock.
        laid: where the frame is.
    """

    system: int
    booted_s: float
    laid: LaidHome


class LaidFrames:
    """All frames that were laid, oldest first.

    Args:
        clock: the computer's clock, seconds.
        laid: the frames that other runs have laid.
        keep: called with all of them when one is added.
    """

    def __init__(
        self,
        clock: Callable[[], float],
        laid: Sequence[LaidFrame] = (),
        keep: Callable[[Sequence[LaidFrame]], None] = lambda _: None,
    ) -> None:
        self._clock = clock
        self._laid = list(laid)
        self._keep = keep

    def recall(self, frame: MissionFrame, system: int, boot_s: float) -> None:
        """If the frame is not laid yet, lays it where it was laid on this autopilot before, if it
        was.

        Args:
            frame: of the mission.
            system: the vehicle's.
            boot_s: time since its autopilot's boot.
        """
        if not frame.is_laid and (known := self._of(system, boot_s)) is not None:
            frame.recall(known.laid)

    def note(self, frame: MissionFrame, system: int, boot_s: float) -> None:
        """Remembers a frame that was laid; missions in latitude and longitude need no memory."""
        if (laid := frame.laid) is None:
            return
        known = self._of(system, boot_s)
        others = [each for each in self._laid if each is not known]
        new = LaidFrame(system, self._clock() - boot_s, laid)  # clocks may have drifted apart
        self._laid = [*others, new][-MOST_FRAMES:]
        self._keep(self._laid)

    def _of(self, system: int, boot_s: float) -> LaidFrame | None:
        booted_s = self._clock() - boot_s
        for each in reversed(self._laid):
            if each.system == system and abs(each.booted_s - booted_s) <= SAME_BOOT_S:
                return each
        return None
