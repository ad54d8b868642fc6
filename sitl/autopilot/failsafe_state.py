"""Which failsafe acts now, and which mode does it fly?

PX4's rules, as a real PX4 was seen to follow them:

1. A failsafe never changes the mode that was asked for; it flies another one while it lasts. So
   PX4 returns to OFFBOARD by itself when the stream of setpoints comes back.
2. The most severe action wins: `Action` is in order.
3. An action worse than holding waits for COM_FAIL_ACT_T in a hold, so that a pilot can take over;
   a rise from one action to a worse one does not start that time again. A mode that lost what it
   needs (setpoints, position) falls back at once.
4. Some failsafes end with their condition (a link that returns); others only with a change of the
   mode or a disarming (battery, geofence).
5. Asking for another mode during a failsafe takes the vehicle over; a further or worse failsafe
   acts again.
6. An action that needs a position becomes a blind descent without one.

Source: PX4 1.16, src/modules/commander/failsafe/framework.cpp; timings measured.
"""

from __future__ import annotations

from dataclasses import dataclass

from sitl.autopilot.failsafes import FAILSAFES, Action, Cause, Conditions, Failsafe

_MODES = {
    Action.POSITION: "POSCTL",
    Action.ALTITUDE: "ALTCTL",
    Action.HOLD: "AUTO.LOITER",
    Action.RETURN: "AUTO.RTL",
    Action.LAND: "AUTO.LAND",
    Action.DESCEND: "DESCEND",
}
"""Action -> the mode that is flown; none while only warning, or once the motors stop."""


@dataclass(frozen=True, slots=True)
class Active:
    """The failsafe that acts: its cause and its action, which may still be waited for."""

    cause: Cause
    action: Action
    waits: bool


class FailsafeState:
    """The failsafes of one flight.

    Attributes:
        active: the most severe one, None while the intended mode is flown.
        is_waiting: it still holds, COM_FAIL_ACT_T is not over.
    """

    def __init__(self) -> None:
        self.active: Active | None = None
        self.is_waiting = False
        self._kept: dict[Cause, Action] = {}
        self._taken_over: dict[Cause, Action] = {}
        self._waiting_since_s: float | None = None
        self._is_position_lost = False

    def update(self, now: Conditions, now_s: float) -> None:
        """Look at the conditions again."""
        self._is_position_lost = now.is_position_lost
        calling = [
            Active(failsafe.cause, action, failsafe.waits)
            for failsafe in FAILSAFES
            if (action := self._called_for(failsafe, now)) is not None
        ]
        self.active = max(calling, key=lambda active: active.action, default=None)
        waits = [active for active in calling if active.waits and active.action > Action.HOLD]
        if not waits:
            self._waiting_since_s = None
        elif self._waiting_since_s is None:
            self._waiting_since_s = now_s
        self.is_waiting = (
            self.active is not None
            and self.active.waits
            and self._waiting_since_s is not None
            and now_s - self._waiting_since_s < now.parameters["COM_FAIL_ACT_T"]
        )

    @property
    def mode(self) -> str | None:
        """The mode to fly instead of the intended one, None if that one is flown."""
        if self.active is None:
            return None
        action = Action.HOLD if self.is_waiting else self.active.action
        if self._is_position_lost and Action.HOLD <= action <= Action.LAND:
            action = Action.DESCEND
        return _MODES.get(action)

    @property
    def stops_motors(self) -> bool:
        """The action is to stop the motors, wherever the vehicle is."""
        return self.active is not None and self.active.action >= Action.DISARM

    def take_over(self) -> None:
        """A mode was asked for: what acts now shall not act again, unless it gets worse."""
        if self.active and self.active.waits:
            self._taken_over |= self._kept | {self.active.cause: self.active.action}
        self._kept.clear()

    def _called_for(self, failsafe: Failsafe, now: Conditions) -> Action | None:
        action = failsafe.action(now)
        if self._taken_over:
            action = self._unless_taken_over(failsafe.cause, action)
        if failsafe.is_kept and (self._kept or action is not None):
            called = [each for each in (action, self._kept.get(failsafe.cause)) if each is not None]
            if called:
                self._kept[failsafe.cause] = action = max(called)
        return action

    def _unless_taken_over(self, cause: Cause, action: Action | None) -> Action | None:
        allowed = self._taken_over.get(cause)
        if action is None:
            self._taken_over.pop(cause, None)  # once it is over, the next one acts again
        return None if action is not None and allowed is not None and action <= allowed else action
