"""Selects the failsafe that acts, and the mode that it flies.

PX4's rules, as observed:

1. A failsafe never changes the intended mode; it flies another one while it lasts. So PX4 returns
   to OFFBOARD by itself when the stream of setpoints comes back.
2. The most severe action wins: `FailsafeAction` is in order of severity.
3. An action worse than holding is delayed by COM_FAIL_ACT_T in a hold, so that a pilot can take
   over. A change to a worse action does not restart this time. A mode that has lost its requirement
   (setpoints, position) falls back at once; motors are stopped at once.
4. Some failsafes end with their condition (such as a link that returns). Others are latched until
   the mode is changed or the vehicle disarmed (battery, geofence).
5. A change of the mode during a failsafe overrides it; another or worse failsafe acts again.
6. Without a position, an action that needs one becomes a descent.

    stage      holds while the selected action is          flown
    INACTIVE   none                                        the intended mode
    WARNING    WARN                                        the intended mode
    DELAYED    worse than HOLD, within COM_FAIL_ACT_T      AUTO.LOITER
    ACTING     any other that has a mode                   the mode of the action
    STOPPING   DISARM or TERMINATE                         nothing, the motors stop

Source: PX4 1.16, src/modules/commander/failsafe/framework.cpp; timings measured.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from sitl.autopilot.failsafes import (
    FAILSAFES,
    Failsafe,
    FailsafeAction,
    FailsafeCause,
    FailsafeInputs,
)

_MODES = {
    FailsafeAction.POSITION: "POSCTL",
    FailsafeAction.ALTITUDE: "ALTCTL",
    FailsafeAction.HOLD: "AUTO.LOITER",
    FailsafeAction.RETURN: "AUTO.RTL",
    FailsafeAction.LAND: "AUTO.LAND",
    FailsafeAction.DESCEND: "DESCEND",
}
"""Action -> the mode that it flies."""


class FailsafeStage(Enum):
    """The stages of a failsafe; the module's table says when each holds."""

    INACTIVE = "inactive"
    WARNING = "warning"
    DELAYED = "delayed"
    ACTING = "acting"
    STOPPING = "stopping"


@dataclass(frozen=True, slots=True)
class SelectedAction:
    """The most severe action demanded, and its cause."""

    cause: FailsafeCause
    action: FailsafeAction
    allows_delay: bool


class FailsafeState:
    """The failsafes of one flight.

    Attributes:
        selected: the most severe action; None while none is demanded.
        stage: the stage of the selected action.
        mode: flown instead of the intended one; None if the intended one is flown.
    """

    def __init__(self) -> None:
        self.selected: SelectedAction | None = None
        self.stage = FailsafeStage.INACTIVE
        self.mode: str | None = None
        self._latched: dict[FailsafeCause, FailsafeAction] = {}
        self._taken_over: dict[FailsafeCause, FailsafeAction] = {}
        self._delayed_since_s: float | None = None

    @property
    def stops_motors(self) -> bool:
        """Whether the action is to stop the motors, wherever the vehicle is."""
        return self.stage is FailsafeStage.STOPPING

    def update(self, now: FailsafeInputs, now_s: float) -> None:
        """Selects action and stage for new inputs."""
        calling = [
            SelectedAction(failsafe.cause, action, failsafe.allows_delay)
            for failsafe in FAILSAFES
            if (action := self._called_for(failsafe, now)) is not None
        ]
        self.selected = max(calling, key=lambda each: each.action, default=None)
        if not any(each.allows_delay and each.action > FailsafeAction.HOLD for each in calling):
            self._delayed_since_s = None
        elif self._delayed_since_s is None:
            self._delayed_since_s = now_s
        since_s, delay_s = self._delayed_since_s, now.parameters["COM_FAIL_ACT_T"]
        self.stage = _stage(self.selected, since_s is not None and now_s - since_s < delay_s)
        self.mode = _mode(self.selected, self.stage, now.is_position_lost)

    def take_over(self) -> None:
        """Notes a commanded mode: the selected action is not repeated unless it gets worse."""
        if self.selected and self.selected.allows_delay:
            self._taken_over |= self._latched | {self.selected.cause: self.selected.action}
        self._latched.clear()

    def _called_for(self, failsafe: Failsafe, now: FailsafeInputs) -> FailsafeAction | None:
        action = failsafe.action(now)
        if self._taken_over:
            action = self._unless_taken_over(failsafe.cause, action)
        if failsafe.is_latched and (self._latched or action is not None):
            latched = self._latched.get(failsafe.cause)
            called = [each for each in (action, latched) if each is not None]
            if called:
                self._latched[failsafe.cause] = action = max(called)
        return action

    def _unless_taken_over(
        self, cause: FailsafeCause, action: FailsafeAction | None
    ) -> FailsafeAction | None:
        allowed = self._taken_over.get(cause)
        if action is None:
            self._taken_over.pop(cause, None)  # once its condition has ended, it acts again
        return None if action is not None and allowed is not None and action <= allowed else action


def _stage(selected: SelectedAction | None, is_within_delay: bool) -> FailsafeStage:
    """The stage by the module's table."""
    if selected is None:
        return FailsafeStage.INACTIVE
    if selected.action is FailsafeAction.WARN:
        return FailsafeStage.WARNING
    if selected.action >= FailsafeAction.DISARM:
        return FailsafeStage.STOPPING
    is_delayed = selected.allows_delay and is_within_delay
    return FailsafeStage.DELAYED if is_delayed else FailsafeStage.ACTING


def _mode(
    selected: SelectedAction | None, stage: FailsafeStage, is_position_lost: bool
) -> str | None:
    if selected is None or stage not in (FailsafeStage.DELAYED, FailsafeStage.ACTING):
        return None
    action = FailsafeAction.HOLD if stage is FailsafeStage.DELAYED else selected.action
    if is_position_lost and FailsafeAction.HOLD <= action <= FailsafeAction.LAND:
        action = FailsafeAction.DESCEND
    return _MODES[action]
