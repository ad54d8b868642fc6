"""Detects that the autopilot holds because it no longer heard us, and nobody has chosen a mode.

Such a hold is not a pilot's decision, so it is a key by which control may come back. Rules:

1. The stream of setpoints was interrupted: for half a second nothing was heard of the vehicle, or
   this program did nothing; or this program has just been started.
2. Within five seconds after that, hold is heard together with a failsafe.
3. Since then only hold with a failsafe and OFFBOARD have been heard.

Anything else (a pilot's mode, a return, a landing, hold without a failsafe) ends it until the next
interruption. After control was taken back, a failsafe that follows is a different one, such as a
fence that was left. Source: PX4 v1.16 as observed (COM_OF_LOSS_T 1 s, COM_OBL_RC_ACT 5).
"""

from __future__ import annotations

from companion.vehicle.heard_time import QUIET_S, Interruption
from companion.vehicle.ports.state import Mode, VehicleState


class StreamLossWatch:
    """Checks the vehicle's state once a tick.

    Attributes:
        is_hold: whether the autopilot holds because it no longer heard us.
    """

    def __init__(self) -> None:
        self.is_hold = False
        self._interruption = Interruption()

    def note_control_back(self) -> None:
        """Notes that we have control: a later hold has another cause than before."""
        self._interruption.forget()

    def step(self, now_s: float, state: VehicleState) -> None:
        """Takes the state of a tick."""
        self._interruption.step(now_s, is_quiet=state.motion.silence_s(now_s) >= QUIET_S)
        if not state.heartbeat.is_recent(now_s):
            return
        if state.heartbeat.mode is Mode.OFFBOARD:
            self.is_hold = False
            return
        is_failsafe_hold = state.heartbeat.mode is Mode.LOITER and state.heartbeat.is_failsafe
        self.is_hold = is_failsafe_hold and (self.is_hold or self._interruption.is_recent)
        if not is_failsafe_hold:
            self._interruption.forget()
