"""A vehicle at the gate, its limits, and what the gate says of a setpoint.

Numbers are exact in binary, so a limit can be met exactly.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from companion.vehicle.gate import Envelope, Request, Verdict, admit
from companion.vehicle.port import Mode, Setpoint, VehicleState, hold_at

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
STATE = VehicleState(
    stamp_s=NOW_S - 0.125,
    position=(5.0, 15.0, -2.25),
    velocity=(1.0, 0.0, 0.0),
    yaw_rad=0.5,
    mode=Mode.OFFBOARD,
    is_armed=True,
    is_landed=False,
    is_failsafe=False,
    battery_percent=80,
    mode_s=NOW_S - 1.0,
    position_s=NOW_S - 0.125,
    yaw_s=NOW_S - 0.125,
)
GOOD = Setpoint((5.5, 15.0, -2.25), (1.0, 0.0, 0.0), (0.5, 0.0, 0.0), 0.25)
HOLD = hold_at(STATE.position, STATE.yaw_rad)
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
    return replace(STATE, **fields)
