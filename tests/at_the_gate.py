"""A vehicle at the gate, its limits, and what the gate says of a setpoint.

Numbers are exact in binary, so a limit can be met exactly.
"""

from __future__ import annotations

from typing import Any

from states import changed, flying

from companion.vehicle.gate import Envelope, Request, Verdict, admit
from companion.vehicle.ports.setpoints import Setpoint, hold_at
from companion.vehicle.ports.state import VehicleState

ENVELOPE = Envelope(
    fence=((0.0, -20.0), (0.0, 20.0), (10.0, 20.0), (10.0, -20.0)),
    up_m=(0.5, 4.0),
    speed_mps=2.0,
    climb_mps=1.5,
    descent_mps=1.0,
    carrot_m=1.5,
    fence_margin_m=0.25,
)
NOW_S = 100.0
STATE = changed(
    flying((5.0, 15.0, -2.25), NOW_S - 0.125),
    velocity=(1.0, 0.0, 0.0),
    yaw_rad=0.5,
    heartbeat_received_s=NOW_S - 1.0,
)
GOOD = Setpoint((5.5, 15.0, -2.25), (1.0, 0.0, 0.0), (0.5, 0.0, 0.0), 0.25)
HOLD = hold_at(STATE.motion.position, STATE.attitude.yaw_rad)
AFTER = 2.0**-20
"""Just beyond."""


def verdict(
    setpoint: Setpoint = GOOD,
    state: VehicleState | None = STATE,
    envelope: Envelope = ENVELOPE,
    asked_s: float = NOW_S,
    is_for_task: bool = False,
    is_entering: bool = False,
    is_violated: bool = False,
) -> Verdict:
    request = Request(setpoint, asked_s, is_for_task)
    return admit(request, state, NOW_S, envelope, is_entering=is_entering, is_violated=is_violated)


def heard(**fields: Any) -> VehicleState:
    return changed(STATE, **fields)
