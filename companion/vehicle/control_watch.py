"""Whether control is still ours, by the autopilot's heartbeats alone.

A heartbeat of another mode than ours may be the pilot's, or forged: anybody on a link without
signatures can send one. The pilot loses nothing by our doubt, as nothing is sent in it.

Rules:
1. A heartbeat of another mode begins a doubt: nothing is sent from the same tick on, and what it
   says is not believed yet.
2. A second one in a row, or one by which a failsafe acts on an armed vehicle: control is lost.
3. A heartbeat of our mode ends the doubt. Within CONTRADICTED_S it comes from another sender, as an
   autopilot speaks once a second, and control was ours all the time. A later one may follow upon a
   pilot who has come and gone, and one that tells of a disarming upon a pilot's landing: control is
   lost.
4. What is lost stays lost until it is given back (`regain`).
5. A pause of ours, in which the autopilot may have missed setpoints, begins a doubt as well: the
   next heartbeat is taken as if there had been none.

    state     heartbeat of our mode        of another mode
    OURS      OURS                         DOUBTED, by a failsafe LOST
    DOUBTED   OURS, or by rule 3 LOST      LOST, or by rule 5 as OURS
    LOST      LOST                         LOST

Source: https://mavlink.io/en/services/heartbeat.html; PX4 v1.16, HEARTBEAT at 1 Hz.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from companion.vehicle.port import Mode, Takeover

CONTRADICTED_S = 0.9
"""Time within which two heartbeats of one autopilot do not come: it sends one a second."""
PAUSED_S = 0.9
"""Between two ticks: a PX4 misses setpoints after a second (COM_OF_LOSS_T), and holds."""


@dataclass(frozen=True, slots=True)
class Heartbeat:
    """What an autopilot's HEARTBEAT says.

    Attributes:
        is_failsafe: a system status of CRITICAL or worse.
    """

    mode: Mode
    is_armed: bool
    is_failsafe: bool


class ControlState(Enum):
    """Whose the vehicle is, as far as heartbeats tell."""

    OURS = "ours"
    DOUBTED = "doubted"
    LOST = "lost"


class ControlWatch:
    """Takes every heartbeat of the autopilot in flight, in their order.

    >>> watch = ControlWatch()
    >>> watch.take(5.0, Heartbeat(Mode.POSCTL, True, False), is_our_mode=False)
    >>> watch.state, watch.takeover
    (<ControlState.DOUBTED: 'doubted'>, None)
    >>> watch.take(6.0, Heartbeat(Mode.POSCTL, True, False), is_our_mode=False)
    >>> print(watch.takeover)
    the pilot has control, in POSCTL

    Attributes:
        state: as of the newest heartbeat.
        takeover: who has control, where it is lost.
    """

    def __init__(self) -> None:
        self.state = ControlState.OURS
        self.takeover: Takeover | None = None
        self._doubted: tuple[float, Heartbeat] | None = None
        self._was_armed = False  # before the doubt
        self._stepped_s = math.inf

    def step(self, now_s: float) -> None:
        """Begins a tick, before what was heard in it."""
        if now_s - self._stepped_s >= PAUSED_S and self.state is ControlState.OURS:
            self.state = ControlState.DOUBTED
        self._stepped_s = now_s

    def take(self, now_s: float, heartbeat: Heartbeat, is_our_mode: bool) -> None:
        """Takes a heartbeat.

        Args:
            now_s: when it was heard.
            heartbeat: what it says.
            is_our_mode: its mode is one that the present goal passes through.
        """
        if self.state is ControlState.LOST:
            return
        doubted, self._doubted = self._doubted, None
        if is_our_mode:
            if doubted is not None and not self._contradicts(heartbeat, now_s - doubted[0]):
                self._lose(doubted[1])
            else:
                self.state, self._was_armed = ControlState.OURS, heartbeat.is_armed
        elif doubted is not None or (heartbeat.is_failsafe and heartbeat.is_armed):
            self._lose(heartbeat)
        else:
            self.state, self._doubted = ControlState.DOUBTED, (now_s, heartbeat)

    def settle(self) -> None:
        """Ends a doubt, as nothing is flown; what is lost stays lost."""
        if self.state is ControlState.DOUBTED:
            self.regain()

    def regain(self) -> None:
        """Control is given back."""
        self.state, self.takeover, self._doubted = ControlState.OURS, None, None

    def _contradicts(self, heartbeat: Heartbeat, after_s: float) -> bool:
        is_disarming = self._was_armed and not heartbeat.is_armed
        return after_s <= CONTRADICTED_S and not is_disarming

    def _lose(self, heartbeat: Heartbeat) -> None:
        self.state = ControlState.LOST
        self.takeover = Takeover(heartbeat.mode, heartbeat.is_failsafe)
