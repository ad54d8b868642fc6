"""Decides from the autopilot's heartbeats alone whether the companion still has control.

A heartbeat with a mode that is not ours may mean that the pilot has taken over. It may also be
forged: on a link without signatures anybody can send one. Doubting it costs the pilot nothing, as
the companion sends nothing meanwhile.

Rules:
1. A heartbeat with another mode begins a doubt: from the same tick on nothing is sent, and the
   content of the heartbeat is not believed yet.
2. Control is lost with a second such heartbeat in a row, or with a first one that reports a
   failsafe on an armed vehicle.
3. A heartbeat with our mode ends the doubt. If it comes within CONTRADICTED_S, the doubted one was
   sent by somebody else, as an autopilot sends one a second: control was ours all the time. If it
   comes later, a pilot may have come and gone; if it reports a disarming, a pilot may have landed.
   In both cases control is lost.
4. Lost control stays lost until it is given back (`regain`).
5. A pause of the companion, in which the autopilot may have missed setpoints, also begins a doubt.
   The next heartbeat is then judged as if there were no doubt.

    state     heartbeat of our mode        of another mode
    OURS      OURS                         DOUBTED, by a failsafe LOST
    DOUBTED   OURS, or by rule 3 LOST      LOST, or by rule 5 as OURS
    LOST      LOST                         LOST

Source: https://mavlink.io/en/services/heartbeat.html; PX4 v1.16, HEARTBEAT at 1 Hz.
"""

from __future__ import annotations

import math
from enum import Enum

from companion.vehicle.ports.control import Takeover
from companion.vehicle.ports.state import Heartbeat

CONTRADICTED_S = 0.9
"""Two heartbeats of one autopilot are never this close together: it sends one a second."""
PAUSED_S = 0.9
"""Between two ticks: a PX4 that misses setpoints for a second (COM_OF_LOSS_T) holds."""


class ControlState(Enum):
    """Who has control, as far as heartbeats tell."""

    OURS = "ours"
    DOUBTED = "doubted"
    LOST = "lost"


class ControlWatch:
    """Takes every heartbeat of the autopilot in flight, in order.

    Implements `ports.control.VehicleControl`.

    >>> from companion.vehicle.ports.state import Mode
    >>> watch = ControlWatch()
    >>> watch.take(Heartbeat(Mode.POSCTL, True, False, received_s=5.0), is_our_mode=False)
    >>> watch.state, watch.takeover
    (<ControlState.DOUBTED: 'doubted'>, None)
    >>> watch.take(Heartbeat(Mode.POSCTL, True, False, received_s=6.0), is_our_mode=False)
    >>> print(watch.takeover)
    the pilot has control, in POSCTL

    Attributes:
        state: as of the newest heartbeat.
        takeover: who has control, if it is lost.
    """

    def __init__(self) -> None:
        self.state = ControlState.OURS
        self.takeover: Takeover | None = None
        self._doubted: Heartbeat | None = None
        self._was_armed = False  # before the doubt
        self._stepped_s = math.inf

    @property
    def is_doubted(self) -> bool:
        """Whether, by the newest heartbeat, somebody else may have control; nothing is sent
        meanwhile."""
        return self.state is ControlState.DOUBTED

    def step(self, now_s: float) -> None:
        """Begins a tick; call it before the heartbeats of that tick."""
        if now_s - self._stepped_s >= PAUSED_S and self.state is ControlState.OURS:
            self.state = ControlState.DOUBTED
        self._stepped_s = now_s

    def take(self, heartbeat: Heartbeat, is_our_mode: bool) -> None:
        """Takes a heartbeat.

        Args:
            heartbeat: the newest one.
            is_our_mode: whether the present goal passes through its mode.
        """
        if self.state is ControlState.LOST:
            return
        doubted, self._doubted = self._doubted, None
        if is_our_mode:
            if doubted is not None and not self._contradicts(heartbeat, doubted):
                self._lose(doubted)
            else:
                self.state, self._was_armed = ControlState.OURS, heartbeat.is_armed
        elif doubted is not None or (heartbeat.is_failsafe and heartbeat.is_armed):
            self._lose(heartbeat)
        else:
            self.state, self._doubted = ControlState.DOUBTED, heartbeat

    def settle(self) -> None:
        """Ends a doubt when nothing is flown; lost control stays lost."""
        if self.state is ControlState.DOUBTED:
            self.regain()

    def regain(self) -> None:
        """Takes note that control was given back."""
        self.state, self.takeover, self._doubted = ControlState.OURS, None, None

    def _contradicts(self, heartbeat: Heartbeat, doubted: Heartbeat) -> bool:
        is_disarming = self._was_armed and not heartbeat.is_armed
        after_s = heartbeat.received_s - doubted.received_s
        return after_s <= CONTRADICTED_S and not is_disarming

    def _lose(self, heartbeat: Heartbeat) -> None:
        self.state = ControlState.LOST
        self.takeover = Takeover(heartbeat.mode, heartbeat.is_failsafe)
