"""Whoever sends to the port cannot divert what goes to the autopilot."""

from __future__ import annotations

import random

import pytest

from companion.mavlink.framing import MavlinkCodec, dialect
from companion.vehicle.autopilot_address import SILENT_S, AutopilotAddress

AUTOPILOT, ATTACKER = ("127.0.0.1", 14580), ("127.0.0.1", 40000)


def heartbeat(system: int = 1, component: int = 1, autopilot: int = 12) -> bytes:
    message = dialect.MAVLink_heartbeat_message(2, autopilot, 0, 0, 3, 3)
    return MavlinkCodec(system, component).pack(message)


def attitude() -> bytes:
    return MavlinkCodec(1, 1).pack(dialect.MAVLink_attitude_message(0, 0, 0, 0, 0, 0, 0))


def damaged(frame: bytes) -> bytes:
    return frame[:-1] + bytes([frame[-1] ^ 1])


@pytest.fixture
def met() -> AutopilotAddress:
    found = AutopilotAddress()
    found.hear(0.0, AUTOPILOT, heartbeat())
    assert (found.system, found.address) == (1, AUTOPILOT)
    return found


WORTHLESS = {
    "a damaged heartbeat": damaged(heartbeat()),
    "a header alone": heartbeat()[:10],
    "another message": attitude(),
    "another component": heartbeat(component=191),
    "no autopilot": heartbeat(autopilot=dialect.MAV_AUTOPILOT_INVALID),
    "nothing": b"",
}


@pytest.mark.parametrize("datagram", WORTHLESS.values(), ids=WORTHLESS)
def test_nothing_but_a_heartbeat_of_an_autopilot_is_learned_from(datagram: bytes) -> None:
    address = AutopilotAddress()
    address.hear(0.0, ATTACKER, datagram)
    assert (address.system, address.address) == (None, None)


@pytest.mark.parametrize("datagram", [heartbeat(), heartbeat(2), *WORTHLESS.values()])
def test_an_autopilot_that_lives_keeps_its_address(met: AutopilotAddress, datagram: bytes) -> None:
    for tick in range(1, 100):
        met.hear(tick * 0.1, ATTACKER, datagram)
        if tick % 10 == 0:
            met.hear(tick * 0.1, AUTOPILOT, heartbeat())
        assert met.address == AUTOPILOT


def test_a_restarted_autopilot_is_found_at_its_new_address(met: AutopilotAddress) -> None:
    moved = ("127.0.0.1", 14581)
    met.hear(SILENT_S, moved, heartbeat())
    assert met.address == AUTOPILOT
    met.hear(SILENT_S + 0.1, moved, heartbeat())
    assert met.address == moved


def test_another_vehicle_never_takes_the_place_of_the_first(met: AutopilotAddress) -> None:
    met.hear(100.0, ATTACKER, heartbeat(system=2))
    assert (met.system, met.address) == (1, AUTOPILOT)


def test_a_heartbeat_among_others_in_one_datagram() -> None:
    address = AutopilotAddress()
    address.hear(0.0, AUTOPILOT, attitude() + damaged(heartbeat(3)) + heartbeat(2))
    assert address.system == 2


def test_garbage_teaches_nothing(met: AutopilotAddress) -> None:
    chance = random.Random(7)
    for number in range(5_000):
        size = chance.randrange(60)
        met.hear(number * 1e-4, ATTACKER, b"\xfd" + chance.randbytes(size))
    assert met.address == AUTOPILOT
