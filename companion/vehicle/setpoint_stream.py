"""The stream of setpoints: passes the last requested setpoint through the gate, as a message.

Nothing here repeats a setpoint by itself: a tick sends one at most, and its lease ends unless it is
renewed (`gate.py`). What passes the gate is converted to the autopilot's own measure: positions to
its local frame, velocities by the error of its estimate (`velocity_bias.py`).
"""

from __future__ import annotations

from dataclasses import replace

from companion.geofence import KeptFence
from companion.geometry import Ned
from companion.mavlink.framing import Message, dialect
from companion.outcomes import Refusal
from companion.vehicle.gate import Envelope, Request, Verdict, admit
from companion.vehicle.ports.setpoints import Setpoint
from companion.vehicle.telemetry import Telemetry
from companion.vehicle.velocity_bias import STILL
from companion.vehicle.wire import AUTOPILOT

ALL_BUT_YAW_RATE = dialect.POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE


class SetpointStream:
    """The setpoints of one flight; implements `ports.setpoints.Setpoints`.

    Args:
        telemetry: of the vehicle.
        envelope: limits of the gate.

    Attributes:
        refusal: why the last message was a hold in place of the setpoint; None if it was not.
    """

    def __init__(self, telemetry: Telemetry, envelope: Envelope) -> None:
        self.refusal: Refusal | None = None
        self._telemetry = telemetry
        self._envelope = envelope
        self._request: Request | None = None
        self._verdict: Verdict | None = None
        self._is_violated = False
        self._now_s = 0.0

    def step(self, now_s: float) -> None:
        """Begins a tick: the lease of a setpoint that is given from now on begins at this time."""
        self._now_s = now_s

    def fly(
        self, setpoint: Setpoint, *, is_for_task: bool = False, is_landing: bool = False
    ) -> None:
        """Streams a setpoint in place of the one before; the caller renews it before its lease
        ends."""
        self._request = Request(setpoint, self._now_s, is_for_task, is_landing)

    def end(self) -> None:
        """Drops the request."""
        self._request = self._verdict = None

    def set_speed_limit(self, speed_mps: float) -> None:
        """Sets the gate's speed limit."""
        if speed_mps != self._envelope.speed_mps:
            self._envelope = replace(self._envelope, speed_mps=speed_mps)

    def keep_within(self, fence: KeptFence) -> None:
        """Lets the gate refuse setpoints outside a fence from now on."""
        envelope = self._envelope
        keep_out = (*envelope.keep_out, *fence.keep_out)
        self._envelope = replace(envelope, within=fence.within, keep_out=keep_out)

    def set_violated(self, is_violated: bool) -> None:
        """Sets whether the gate refuses setpoints of the task's plan."""
        self._is_violated = is_violated

    def due(self, now_s: float, system: int, is_entering: bool) -> list[Message]:
        """The setpoint that passes the gate, as a message; at most one.

        Args:
            now_s: the time.
            system: id of the vehicle.
            is_entering: OFFBOARD is about to be requested.
        """
        self.refusal = None
        if self._request is None:
            return []
        self._verdict = verdict = admit(
            self._request,
            self._telemetry.state,
            now_s,
            self._envelope,
            is_entering=is_entering,
            is_violated=self._is_violated,
            frame_doubt=self._telemetry.placed.doubt,
            before=self._verdict,
        )
        if verdict.setpoint is None:
            return []
        self.refusal = verdict.refusal
        bias = self._velocity_bias(now_s)
        velocity = [v + off for v, off in zip(verdict.setpoint.velocity, bias, strict=True)]
        return [
            dialect.MAVLink_set_position_target_local_ned_message(
                int(now_s * 1000) & 0xFFFFFFFF,
                system,
                AUTOPILOT,
                dialect.MAV_FRAME_LOCAL_NED,
                ALL_BUT_YAW_RATE,
                *self._telemetry.frame.local(verdict.setpoint.position),
                *velocity,
                *verdict.setpoint.acceleration,
                verdict.setpoint.yaw_rad,
                0.0,
            )
        ]

    def _velocity_bias(self, now_s: float) -> Ned:
        """The error of the autopilot's velocity in flight; zero on the ground, where nothing
        moves."""
        state = self._telemetry.state
        is_flying = state is not None and not state.is_landed
        return self._telemetry.velocity_bias.at(now_s) if is_flying else STILL
