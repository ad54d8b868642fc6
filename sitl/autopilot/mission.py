"""Which item of its mission does the vehicle fly, and what comes after it?

`Mission` is the plan and how far it has been flown; it outlives the mode, so that AUTO.MISSION goes
on where it was left. `MissionFlight` is the mode while it is flown. PX4's rules:

1. A mission that has come in is checked first; until then there is none.
2. Items are flown in order. One that does not move the vehicle is reached at once. Each is
   reported, but for DO_JUMP, which only says what comes next.
3. On the ground, a take-off over the present place comes before an item with a place; it is not
   reported.
4. After the last item the vehicle holds, in AUTO.LOITER. The current item stays the last one; a
   mission that was flown to its end begins anew after the next arming.
5. RETURN_TO_LAUNCH is reached at once and hands over to AUTO.RTL.
6. A leg that was left for another mode begins anew. A speed set by an item before it holds again.

Source: PX4 1.16, src/modules/navigator/mission_base.cpp, mission_block.cpp; the reports were seen
on a PX4. Left out: checks of a mission's feasibility (PX4's default parameters demand little).
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum

from sitl.autopilot.basic_modes import Hold
from sitl.autopilot.mission_items import Command, Item, speed_before
from sitl.autopilot.mission_legs import LEGS, NEEDS_HEIGHT, Climb, Leg
from sitl.autopilot.return_mode import Return
from sitl.autopilot.situation import Situation, Succession, heading
from sitl.flight.controllers import Target

CHECKED_S = 0.02  # PX4 was seen to refuse a mission 0.01 s after its upload
MAX_JUMPS = 10  # DO_JUMP after DO_JUMP; PX4 gives up then
_ACTIVE_MODES = frozenset({"AUTO.MISSION", "AUTO.TAKEOFF", "AUTO.LAND"})


class MissionState(IntEnum):
    """How far a mission is; the values are MISSION_STATE."""

    NO_MISSION = 1
    NOT_STARTED = 2
    ACTIVE = 3
    PAUSED = 4
    COMPLETE = 5


class Mission:
    """A plan and how far it has been flown.

    Attributes:
        items: in order.
        current: index of the item that is flown now or next.
        is_complete: flown to the end.
        revision: goes up when another item is to be flown than the order says.
        reached: items reached since whoever reports them has emptied the list.
    """

    def __init__(self) -> None:
        self.items: tuple[Item, ...] = ()
        self.current = 0
        self.is_complete = False
        self.revision = 0
        self.reached: list[int] = []
        self._loaded_s = 0.0
        self._has_begun = False
        self._begins_anew = False
        self._jumps: dict[int, int] = {}

    def load(self, items: Sequence[Item], current: int | None, now_s: float) -> None:
        """Replace the plan.

        Args:
            items: the new one, empty for none.
            current: the item to begin with; None keeps the index as far as it exists.
            now_s: the time.
        """
        self.items = tuple(items)
        wanted = self.current if current is None else current
        self.current = max(0, min(wanted, len(self.items) - 1))
        self.is_complete = self._has_begun = self._begins_anew = False
        self._jumps.clear()
        self._loaded_s = now_s
        self.revision += 1

    def is_ready(self, now_s: float) -> bool:
        """There is a mission, and it has been checked."""
        return bool(self.items) and now_s - self._loaded_s >= CHECKED_S

    def state(self, mode: str, now_s: float) -> MissionState:
        """How far the mission is while a mode is flown."""
        if not self.is_ready(now_s):
            return MissionState.NO_MISSION
        if self.is_complete:
            return MissionState.COMPLETE
        if self.is_active(mode):
            return MissionState.ACTIVE
        return MissionState.PAUSED if self._has_begun else MissionState.NOT_STARTED

    def is_active(self, mode: str) -> bool:
        """The mode belongs to missions, as MISSION_CURRENT.mission_mode means it."""
        return mode in _ACTIVE_MODES

    def set_current(self, index: int) -> bool:
        """Go on with another item; False if there is none with this index."""
        if not 0 <= index < len(self.items):
            return False
        self.current = index
        self.is_complete = self._begins_anew = False
        self.revision += 1
        return True

    def disarmed(self) -> None:
        """The motors have stopped: a mission at its last item is over."""
        self._begins_anew = self._has_begun and self.current == len(self.items) - 1

    def start(self, now: Situation) -> MissionFlight:
        """The mode in flight."""
        return MissionFlight(self, now)

    # For the mode alone.

    def begin(self) -> bool:
        """The mode flies its first item: which one? False if the mission has none."""
        if self._begins_anew:
            self.current = 0
            self._jumps.clear()
        self._has_begun, self._begins_anew, self.is_complete = True, False, False
        return self._go_to(self.current, counts=False)

    def advance(self) -> bool:
        """Go on to the next item; False after the last one."""
        return self._go_to(self.current + 1, counts=True)

    def _go_to(self, index: int, *, counts: bool) -> bool:
        """Make an item the current one, or where its DO_JUMP leads."""
        for _ in range(MAX_JUMPS):
            if not 0 <= index < len(self.items):
                break
            item = self.items[index]
            if item.command != Command.DO_JUMP:
                self.current = index
                return True
            index = self._after_jump(index, item, counts)
        self.is_complete = True
        self._jumps.clear()
        return False

    def _after_jump(self, index: int, item: Item, counts: bool) -> int:
        done = self._jumps.get(index, 0)
        if done >= item.repetitions or not 0 <= item.jumps_to < len(self.items):
            return index + 1
        if counts:
            self._jumps[index] = done + 1
        return item.jumps_to


class MissionFlight:
    """AUTO.MISSION, from entering to leaving it."""

    def __init__(self, mission: Mission, now: Situation) -> None:
        self._mission = mission
        self._hold = Hold.start(now)
        self._leg: Leg | None = None
        self._is_lifting = False
        self._is_waiting = False
        self._revision: int | None = None

    def target(self, now: Situation) -> Target:
        """The present leg's, or where the last one has led."""
        return self._leg.target(now) if self._leg else self._hold.target(now)

    def successor(self, now: Situation) -> Succession | None:
        """Go on; what follows the mission, None until then."""
        mission = self._mission
        if self._revision != mission.revision:
            self._revision = mission.revision
            return self._next(now, is_there=mission.begin())
        if self._is_waiting or (self._leg and not self._leg.is_done(now)):
            return None
        if self._is_lifting:
            self._is_lifting = False
            self._take(LEGS[self._item.command](self._item, now, self._speed_mps, self._hold))
            return None
        mission.reached.append(mission.current)
        if self._item.command == Command.RETURN_TO_LAUNCH:
            mission.advance()
            return Succession("AUTO.RTL", Return.start(now))
        if not self._item.goes_on:
            self._is_waiting = True
            return None
        return self._next(now, is_there=mission.advance())

    @property
    def _item(self) -> Item:
        return self._mission.items[self._mission.current]

    @property
    def _speed_mps(self) -> float | None:
        return speed_before(self._mission.items, self._mission.current)

    def _next(self, now: Situation, *, is_there: bool) -> Succession | None:
        """Begin the current item, or end without one."""
        if not is_there:
            return self._end(now)
        item = self._item
        self._is_waiting = False
        self._is_lifting = now.is_landed and item.command in NEEDS_HEIGHT
        if self._is_lifting:
            self._take(Climb.to(item.point(now.state.position, now.home)[2], now))
        elif begin := LEGS.get(item.command):
            self._take(begin(item, now, self._speed_mps, self._hold))
        else:
            self._leg = None
        return None

    def _take(self, leg: Leg) -> None:
        self._leg, self._hold = leg, leg.hold()

    def _end(self, now: Situation) -> Succession:
        if now.is_landed:
            hold = Hold(now.state.position, heading(now.state))
            return Succession("AUTO.LOITER", hold, "Mission finished, landed")
        return Succession("AUTO.LOITER", self._hold, "Mission finished, loitering")
