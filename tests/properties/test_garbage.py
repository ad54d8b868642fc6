"""Garbage on any port leaves the simulator flying, and nothing changes that was not asked for.

A few thousand of each kind by default; 200,000 of each with the marker `long`.
"""

import random
import struct
from collections.abc import Callable

import pytest
from pymavlink.generator.mavcrc import x25crc
from wire import Wire

from companion.mavlink.framing import Endpoint, Message, dialect
from sitl.link.component import AutopilotComponent
from sitl.link.routing import LinkName, is_for
from sitl.simulation import Simulation

STEP_EVERY = 200  # datagrams
Garbage = Callable[[random.Random], bytes]

SIZES = {"char": 1, "float": 4, "double": 8} | {
    f"{sign}int{bits}_t": bits // 8 for sign in ("", "u") for bits in (8, 16, 32, 64)
}
KINDS = sorted(dialect.mavlink_map)
TO_US = [n for n in KINDS if dialect.mavlink_map[n].msgname in AutopilotComponent.SERVICES]


def frame(number: int, payload: bytes, rng: random.Random) -> bytes:
    """A MAVLink 2 frame of any component, with a good checksum."""
    system, component = rng.randrange(256), rng.randrange(256)
    head = struct.pack(
        "<BBBBBBBHB", 0xFD, len(payload), 0, 0, rng.randrange(256), system, component,
        number & 0xFFFF, number >> 16,
    )  # fmt: skip
    crc = x25crc(head[1:] + payload)
    crc.accumulate(bytes([dialect.mavlink_map[number].crc_extra]))
    return head + payload + struct.pack("<H", crc.crc)


def payload_of(number: int, rng: random.Random) -> bytes:
    return rng.randbytes(dialect.mavlink_map[number].unpacker.size)


def random_bytes(rng: random.Random) -> bytes:
    return rng.choice((b"", b"\xfd", b"\xfe")) + rng.randbytes(rng.randrange(300))


def truncated_frame(rng: random.Random) -> bytes:
    number = rng.choice(KINDS)
    whole = frame(number, payload_of(number, rng), rng)
    return whole[: rng.randrange(len(whole))]


def any_frame(rng: random.Random) -> bytes:
    number = rng.choice(KINDS)
    return frame(number, payload_of(number, rng), rng)


def frame_for_the_autopilot(rng: random.Random) -> bytes:
    """A message that it answers, addressed to it, with everything else random."""
    number = rng.choice(TO_US)
    kind = dialect.mavlink_map[number]
    payload = bytearray(payload_of(number, rng))
    types = dict(zip(kind.fieldnames, kind.fieldtypes, strict=True))
    at = 0
    for name, length in zip(kind.ordered_fieldnames, kind.array_lengths, strict=True):
        if name in ("target_system", "target_component"):
            payload[at] = 1
        at += SIZES[types[name]] * max(1, length)
    assert at == len(payload)
    return frame(number, bytes(payload), rng)


def state(simulation: Simulation) -> tuple[object, ...]:
    """What a command could change."""
    autopilot = simulation._autopilot
    parameters = tuple(autopilot.parameters._values.values())
    return (
        autopilot.is_armed,
        autopilot.intended_mode,
        autopilot.home,
        autopilot.cruise_mps,
        autopilot._setpoint,
        autopilot._flying,
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
    simulation, ear = wire.simulation, Endpoint(0, 0)
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
    told = [m for _, f in simulation.step(step * 0.004 + 2.0, []) for m in Endpoint(0, 0).parse(f)]
    assert any(m.get_type() == "HEARTBEAT" for m in told)
