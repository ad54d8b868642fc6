"""A mission's items, and how far they have been flown.

The plan outlives the mode that flies it, so AUTO.MISSION continues where it was left. PX4's rules:

1. A new mission is checked first; until then there is no mission.
2. Items are flown in order. DO_JUMP only says what comes next.
3. After the end, the last item stays the current one. A mission whose vehicle was disarmed at the
   last item begins again.

    state         begin                 past the last item   disarmed at the last item
    NOT_STARTED   STARTED
    STARTED       STARTED               COMPLETE             ENDED_EARLY
    COMPLETE      STARTED               COMPLETE             ENDED
    ENDED_EARLY   STARTED, first item
    ENDED         STARTED, first item

A new plan is NOT_STARTED. Another current item makes a plan that has begun STARTED.

Source: PX4 1.16, src/modules/navigator/mission_base.cpp. Left out: checks of a mission's
feasibility (PX4's default parameters demand little).
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum, IntEnum

from sitl.autopilot.mission_items import MissionCommand, MissionItem
from sitl.autopilot.mission_mode import MissionMode
from sitl.autopilot.situation import Situation

CHECKED_S = 0.02  # PX4 was observed to refuse a mission 0.01 s after its upload
MAX_JUMPS = 10  # of DO_JUMPs in a row; then PX4 gives up
_ACTIVE_MODES = frozenset({"AUTO.MISSION", "AUTO.TAKEOFF", "AUTO.LAND"})


class MissionState(IntEnum):
    """The state of a mission as it is reported; the values are MISSION_STATE."""

    NO_MISSION = 1
    NOT_STARTED = 2
    ACTIVE = 3
    PAUSED = 4
    COMPLETE = 5


class PlanState(Enum):
    """The states of a plan; the module's table has their transitions."""

    NOT_STARTED = "not started"
    STARTED = "started"
    COMPLETE = "flown to the end"
    ENDED_EARLY = "disarmed at the last item before that was reached"
    ENDED = "flown to the end, disarmed at the last item"


_DISARMED_AT_THE_LAST_ITEM = {
    PlanState.STARTED: PlanState.ENDED_EARLY,
    PlanState.COMPLETE: PlanState.ENDED,
}
_BEGINS_ANEW = (PlanState.ENDED_EARLY, PlanState.ENDED)
_IS_COMPLETE = (PlanState.COMPLETE, PlanState.ENDED)


class MissionPlan:
    """The items of one vehicle's mission.

    Attributes:
        items: in order.
        current: index of the item that is flown now or next.
        state: how far the plan has been flown.
        revision: increases when the next item is not the one in order.
        reached: items reached; their reporter empties the list.
    """

    def __init__(self) -> None:
        self.items: tuple[MissionItem, ...] = ()
        self.current = 0
        self.state = PlanState.NOT_STARTED
        self.revision = 0
        self.reached: list[int] = []
        self._loaded_s = 0.0
        self._jumps: dict[int, int] = {}

    def load(self, items: Sequence[MissionItem], current: int | None, now_s: float) -> None:
        """Replaces the plan.

        Args:
            items: the new one, empty for none.
            current: index of the first item; None keeps the present index if it exists.
            now_s: the time.
        """
        self.items = tuple(items)
        wanted = self.current if current is None else current
        self.current = max(0, min(wanted, len(self.items) - 1))
        self.state = PlanState.NOT_STARTED
        self._jumps.clear()
        self._loaded_s = now_s
        self.revision += 1

    def is_ready(self, now_s: float) -> bool:
        """Whether there is a mission that has been checked."""
        return bool(self.items) and now_s - self._loaded_s >= CHECKED_S

    def reported_state(self, mode: str, now_s: float) -> MissionState:
        """The state of the mission while a mode is flown."""
        if not self.is_ready(now_s):
            return MissionState.NO_MISSION
        if self.state in _IS_COMPLETE:
            return MissionState.COMPLETE
        if self.is_active(mode):
            return MissionState.ACTIVE
        is_started = self.state is not PlanState.NOT_STARTED
        return MissionState.PAUSED if is_started else MissionState.NOT_STARTED

    def is_active(self, mode: str) -> bool:
        """Whether the mode belongs to missions, as in MISSION_CURRENT.mission_mode."""
        return mode in _ACTIVE_MODES

    def set_current(self, index: int) -> bool:
        """Continues with another item; False if the index does not exist."""
        if not 0 <= index < len(self.items):
            return False
        self.current = index
        if self.state is not PlanState.NOT_STARTED:
            self.state = PlanState.STARTED
        self.revision += 1
        return True

    def note_disarming(self) -> None:
        """Notes that the motors have stopped: a mission at its last item is over."""
        if self.current == len(self.items) - 1:
            self.state = _DISARMED_AT_THE_LAST_ITEM.get(self.state, self.state)

    def start(self, now: Situation) -> MissionMode:
        """AUTO.MISSION."""
        return MissionMode(self, now)

    def begin(self) -> bool:
        """Starts the mode at the current item; False if the mission has no items."""
        if self.state in _BEGINS_ANEW:
            self.current = 0
            self._jumps.clear()
        self.state = PlanState.STARTED
        return self._go_to(self.current, counts=False)

    def advance(self) -> bool:
        """Proceeds to the next item; False after the last one."""
        return self._go_to(self.current + 1, counts=True)

    def _go_to(self, index: int, *, counts: bool) -> bool:
        """Makes an item the current one, or the item to which its DO_JUMP leads."""
        for _ in range(MAX_JUMPS):
            if not 0 <= index < len(self.items):
                break
            item = self.items[index]
            if item.command != MissionCommand.DO_JUMP:
                self.current = index
                return True
            index = self._after_jump(index, item, counts)
        self.state = PlanState.COMPLETE
        self._jumps.clear()
        return False

    def _after_jump(self, index: int, item: MissionItem, counts: bool) -> int:
        done = self._jumps.get(index, 0)
        if done >= item.repetitions or not 0 <= item.jumps_to < len(self.items):
            return index + 1
        if counts:
            self._jumps[index] = done + 1
        return item.jumps_to
