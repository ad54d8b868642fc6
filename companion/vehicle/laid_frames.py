"""Where missions in metres begin on autopilots that were not restarted, in other programs' flights.

The first sortie lays the mission's frame where its vehicle stands (mission_frame.py), and later
ones keep it. A vehicle that has landed stands up to a metre beside home. A program started anew
would lay the frame there, and all walls with it. So it goes on with the frame of the program
before, for as long as the autopilot's local frame is the same: until the autopilot is restarted.

An autopilot is known again by its system id and by when it booted. That is reckoned by the
computer's own clock, which is asked for here: one that no user and no network sets.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from companion.vehicle.mission_frame import LaidHome, MissionFrame

SAME_BOOT_S = 10.0
"""Two reckonings of one boot differ by less: clocks that drift apart by 100 millionths for a day,
or by 2 %, as that of a simulated autopilot on a busy machine, for eight minutes between two
sorties. What lies between two boots takes longer: a flight."""
MOST_FRAMES = 16
"""The newest ones are remembered."""


@dataclass(frozen=True, slots=True)
class LaidFrame:
    """A frame that was laid.

    Attributes:
        system: MAVLink system id of the vehicle.
        booted_s: when its autopilot booted, by the computer's clock.
        laid: where.
    """

    system: int
    booted_s: float
    laid: LaidHome


class LaidFrames:
    """The frames that were laid, oldest first.

    Args:
        clock: of the computer, seconds.
        laid: by other programs.
        keep: told of all of them when there is a new one.
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
        """A frame that is not laid yet goes on where it was laid on this autopilot, if it was.

        Args:
            frame: of the mission.
            system: the vehicle's.
            boot_s: since its autopilot booted.
        """
        if not frame.is_laid and (known := self._of(system, boot_s)) is not None:
            frame.recall(known.laid)

    def note(self, frame: MissionFrame, system: int, boot_s: float) -> None:
        """A frame is laid; one of a mission in latitude and longitude needs no memory."""
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
