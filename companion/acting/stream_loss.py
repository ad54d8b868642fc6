"""Whether the autopilot holds because it no longer heard us, and nobody has chosen a mode since.

Such a hold is a key by which control may come back: it is no decision of a pilot. It is seen so:

1. The stream of setpoints was interrupted: for half a second nothing was heard of the vehicle, or
   this program did nothing; or it has just been started.
2. Hold is heard with a failsafe, five seconds after that at the latest.
3. Since then nothing else was heard but hold with a failsafe, and OFFBOARD.

Anything else (a pilot's mode, a return, a landing, hold without a failsafe) ends it for good, until
the next interruption. Once control was taken back, a failsafe that follows is another one: a fence
that was left. Source: PX4 v1.16 as observed (COM_OF_LOSS_T 1 s, COM_OBL_RC_ACT 5).
"""

from __future__ import annotations

from companion.vehicle.heard_time import QUIET_S, Interruption
from companion.vehicle.port import Mode, VehicleState


class StreamLossWatch:
    """Looks at the vehicle's state once a tick.

    Attributes:
        is_hold: the autopilot holds because it no longer heard us.
    """

    def __init__(self) -> None:
        self.is_hold = False
        self._interruption = Interruption()

    def note_control_back(self) -> None:
        """We have control: what holds the vehicle from now on does not follow from before."""
        self._interruption.forget()

    def step(self, now_s: float, state: VehicleState) -> None:
        """Takes the state of a tick."""
        self._interruption.step(now_s, is_quiet=now_s - state.stamp_s >= QUIET_S)
        if not state.is_mode_known(now_s):
            return
        if state.mode is Mode.OFFBOARD:
            self.is_hold = False
            return
        is_failsafe_hold = state.mode is Mode.LOITER and state.is_failsafe
        self.is_hold = is_failsafe_hold and (self.is_hold or self._interruption.is_recent)
        if not is_failsafe_hold:
            self._interruption.forget()
