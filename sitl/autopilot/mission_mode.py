"""AUTO.MISSION: the mode that flies the items of a plan, one after the other.

PX4's rules:

1. An item that does not move the vehicle is reached at once. Each is reported, except DO_JUMP.
2. On the ground, a take-off over the present place precedes an item with a place; it is not
   reported.
3. After the last item the vehicle holds, in AUTO.LOITER.
4. RETURN_TO_LAUNCH is reached at once and changes to AUTO.RTL.
5. A leg that was left for another mode starts again, with the speed that an earlier item has set.
6. After an item without autocontinue, the vehicle waits there.

    state        goes on when         then
    STARTING     at once              the current item begins
    TAKING_OFF   the climb is done    FLYING, the item's own leg
    FLYING       the leg is done      reached: the next item, WAITING or another mode
    PASSING      at once              the same
    WAITING      never

A plan with a new revision starts again from any state. An item begins as TAKING_OFF (rule 2), as
FLYING if it has a leg, or as PASSING.

Source: PX4 1.16, src/modules/navigator/mission_base.cpp, mission_block.cpp; reports observed on
PX4.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from typing import Protocol

from sitl.autopilot.basic_modes import HoldMode
from sitl.autopilot.mission_items import MissionCommand, MissionItem, speed_before
from sitl.autopilot.mission_legs import LEGS, NEEDS_HEIGHT, Climb, Leg
from sitl.autopilot.return_mode import ReturnMode
from sitl.autopilot.situation import ModeChange, Situation, heading
from sitl.flight.controllers import TrajectorySetpoint


class ItemSequence(Protocol):
    """The items of a mission and the order in which they are flown."""

    @property
    def items(self) -> Sequence[MissionItem]:
        """All items."""

    @property
    def current(self) -> int:
        """Index of the item that is flown now or next."""

    @property
    def revision(self) -> int:
        """A number that changes when the next item is not the one in order."""

    @property
    def reached(self) -> list[int]:
        """The items reached that have not been reported yet."""

    def begin(self) -> bool:
        """Starts the mode at the current item; False if the mission has no items."""

    def advance(self) -> bool:
        """Proceeds to the next item; False after the last one."""


class MissionModeState(Enum):
    """The states of the mode; the module's table has their transitions."""

    STARTING = "starting"
    TAKING_OFF = "taking off"
    FLYING = "flying"
    PASSING = "passing"
    WAITING = "waiting"


class MissionMode:
    """AUTO.MISSION, from entering the mode to leaving it."""

    def __init__(self, mission: ItemSequence, now: Situation) -> None:
        self._mission = mission
        self._revision = mission.revision
        self._state = MissionModeState.STARTING
        self._hold = HoldMode.start(now)
        self._leg: Leg | None = None

    def setpoint(self, now: Situation) -> TrajectorySetpoint:
        """The setpoint of the present leg, or of the hold at the end of the last one."""
        return self._leg.setpoint(now) if self._leg else self._hold.setpoint(now)

    def mode_change(self, now: Situation) -> ModeChange | None:
        """Proceeds through the items; returns the mode after the mission, None until then."""
        mission = self._mission
        if self._state is MissionModeState.STARTING or self._revision != mission.revision:
            self._revision = mission.revision
            return self._go_on(now, has_item=mission.begin())
        if self._state is MissionModeState.WAITING or (self._leg and not self._leg.is_done(now)):
            return None
        if self._state is MissionModeState.TAKING_OFF:
            self._state = MissionModeState.FLYING
            self._take(LEGS[self._item.command](self._item, now, self._speed_mps, self._hold))
            return None
        mission.reached.append(mission.current)
        if self._item.command == MissionCommand.RETURN_TO_LAUNCH:
            mission.advance()
            return ModeChange("AUTO.RTL", ReturnMode.start(now))
        if not self._item.autocontinue:
            self._state = MissionModeState.WAITING
            return None
        return self._go_on(now, has_item=mission.advance())

    @property
    def _item(self) -> MissionItem:
        return self._mission.items[self._mission.current]

    @property
    def _speed_mps(self) -> float | None:
        return speed_before(self._mission.items, self._mission.current)

    def _go_on(self, now: Situation, *, has_item: bool) -> ModeChange | None:
        """Begins the current item, or ends the mission if there is none."""
        if not has_item:
            return self._end(now)
        self._begin_item(now)
        return None

    def _begin_item(self, now: Situation) -> None:
        item = self._item
        if now.is_landed and item.command in NEEDS_HEIGHT:
            self._state = MissionModeState.TAKING_OFF
            self._take(Climb.to(item.point(now.state.position, now.home)[2], now))
        elif leg_from := LEGS.get(item.command):
            self._state = MissionModeState.FLYING
            self._take(leg_from(item, now, self._speed_mps, self._hold))
        else:
            self._state = MissionModeState.PASSING
            self._leg = None

    def _take(self, leg: Leg) -> None:
        self._leg, self._hold = leg, leg.hold()

    def _end(self, now: Situation) -> ModeChange:
        if now.is_landed:
            hold = HoldMode(now.state.position, heading(now.state))
            return ModeChange("AUTO.LOITER", hold, "Mission finished, landed")
        return ModeChange("AUTO.LOITER", self._hold, "Mission finished, loitering")
