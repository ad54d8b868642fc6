"""Garbage on any port leaves the simulator flying, and nothing changes that was not asked for.

A few thousand of each kind by default; 200,000 of each with the marker `long`.
"""

import random
from collections.abc import Callable

import pytest
from garbage import KINDS, any_frame, frame, payload_of, random_bytes, truncated_frame, with_fields
from wire import Wire

from companion.mavlink.framing import MavlinkCodec, Message, dialect
from sitl.link.autopilot_component import AutopilotComponent
from sitl.link.routing import LinkName, is_for
from sitl.simulation import Simulation

STEP_EVERY = 200  # datagrams
Garbage = Callable[[random.Random], bytes]

TO_US = [n for n in KINDS if dialect.mavlink_map[n].msgname in AutopilotComponent.SERVICES]


def frame_for_the_autopilot(rng: random.Random) -> bytes:
    """A message that it answers, addressed to it, with everything else random."""
    number = rng.choice(TO_US)
    us = {"target_system": b"\1", "target_component": b"\1"}
    return frame(number, with_fields(number, payload_of(number, rng), us), rng)


def state(simulation: Simulation) -> tuple[object, ...]:
    """What a command could change."""
    autopilot = simulation._autopilot
    parameters = tuple(autopilot.parameters._values.values())
    return (
        autopilot.is_armed,
        autopilot.intended_mode,
        autopilot.home,
        autopilot.cruise_mps,
        autopilot.setpoint,
        autopilot._active_mode,
        parameters,
    )


def is_answered(message: Message) -> bool:
    return message.get_type() in AutopilotComponent.SERVICES and is_for((1, 1), message)


@pytest.mark.parametrize("garbage", [random_bytes, truncated_frame, any_frame])
@pytest.mark.parametrize(
    "number", [3_000, pytest.param(200_000, marks=pytest.mark.long)], ids=["few", "many"]
)
def test_garbage_changes_nothing(garbage: Garbage, number: int) -> None:
    rng = random.Random(7)
    wire = Wire()
    wire.fly_offboard(2.0, 0.0, -3.0)
    wire.set_mode("AUTO.LOITER")
    simulation, ear = wire.simulation, MavlinkCodec(0, 0)
    step, before = round(wire.now_s / 0.004), state(simulation)
    for i in range(number):
        datagram = garbage(rng)
        link = rng.choice(list(LinkName))
        simulation.step(step * 0.004, [(link, datagram)])
        if any(map(is_answered, ear.parse(datagram))):
            before = state(simulation)
        if i % STEP_EVERY == 0:
            assert state(simulation) == before
            step += 5
    assert state(simulation) == before
    assert simulation.is_armed
    assert simulation.flight.position == pytest.approx((2.0, 0.0, -3.0), abs=0.3)


@pytest.mark.parametrize(
    "number", [3_000, pytest.param(200_000, marks=pytest.mark.long)], ids=["few", "many"]
)
def test_nonsense_for_the_autopilot_is_survived(number: int) -> None:
    rng = random.Random(8)
    wire = Wire()
    wire.fly_offboard(2.0, 0.0, -3.0)
    simulation, step = wire.simulation, round(wire.now_s / 0.004)
    for i in range(number):
        datagram = frame_for_the_autopilot(rng)
        simulation.step(step * 0.004, [(rng.choice(list(LinkName)), datagram)])
        step += i % STEP_EVERY == 0
    told = [
        m for _, f in simulation.step(step * 0.004 + 2.0, []) for m in MavlinkCodec(0, 0).parse(f)
    ]
    assert any(m.get_type() == "HEARTBEAT" for m in told)
