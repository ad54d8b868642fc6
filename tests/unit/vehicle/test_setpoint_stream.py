"""What the gate lets out, as it is sent: in the autopilot's own frame and measure of velocity."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
from fakes import on_hold
from states import changed

from companion.vehicle.gate import Envelope
from companion.vehicle.ports.setpoints import Setpoint
from companion.vehicle.ports.state import Mode
from companion.vehicle.setpoint_stream import SetpointStream
from companion.vehicle.velocity_bias import MOST_MPS, VelocityBias

NOW_S = 50.0
FENCE = ((-9.0, -9.0), (-9.0, 9.0), (9.0, 9.0), (9.0, -9.0))
ENVELOPE = Envelope(FENCE, (0.5, 4.0), 2.0, 1.0, 1.0, 1.5)
FLYING = changed(on_hold(NOW_S), mode=Mode.OFFBOARD)


def bias(off_mps: tuple[float, float]) -> VelocityBias:
    """Of an autopilot that tells so much more than it moves."""
    known = VelocityBias()
    for number in range(100):
        time_s = NOW_S - 3.3 + number / 30
        known.take(time_s, time_s, FLYING.motion.position, (*off_mps, 0.0))
    return known


def sent(setpoint: Setpoint, off_mps: tuple[float, float], **differs: Any) -> tuple[float, ...]:
    telemetry: Any = SimpleNamespace(
        state=replace(FLYING, **differs),
        frame=SimpleNamespace(local=lambda position: position),
        placed=SimpleNamespace(doubt=None),
        velocity_bias=bias(off_mps),
    )
    stream = SetpointStream(telemetry, ENVELOPE)
    stream.step(NOW_S)
    stream.fly(setpoint, is_for_task=True)
    (message,) = stream.due(NOW_S, 1, is_entering=False)
    return (message.vx, message.vy, message.vz)


def to(north_mps: float, north_m: float = 0.5) -> Setpoint:
    (north, east, down) = FLYING.motion.position
    position = (north + north_m, east, down)
    return Setpoint(position, (north_mps, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0)


def test_what_the_velocity_is_off_by_is_added() -> None:
    assert sent(to(1.0), (0.25, -0.15)) == pytest.approx((1.21, -0.13, 0.0), abs=0.02)


def test_the_limit_is_one_of_the_true_speed() -> None:
    assert sent(to(2.0), (0.3, 0.0)) == pytest.approx((2.25, 0.0, 0.0), abs=0.01)


def test_a_hold_of_the_gate_has_it_as_well() -> None:
    assert sent(to(1.0, north_m=50.0), (0.3, 0.0)) == pytest.approx((0.25, 0.0, 0.0), abs=0.01)


def test_it_is_bounded() -> None:
    assert sent(to(0.0), (9.0, 0.0)) == pytest.approx((MOST_MPS, 0.0, 0.0))


def test_on_the_ground_it_moves_nothing() -> None:
    assert sent(to(0.0), (0.3, 0.0), is_landed=True) == (0.0, 0.0, 0.0)
