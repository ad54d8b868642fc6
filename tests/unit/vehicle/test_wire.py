"""The ear and the voice of component 191."""

from __future__ import annotations

import pytest
from autopilot import Autopilot, battery, named

from companion.mavlink.framing import MavlinkCodec, dialect
from companion.vehicle.telemetry import Telemetry
from companion.vehicle.wire import Wire

HEARTBEAT = dialect.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3)


def wire_of(*wanted: str, continual: frozenset[str] = frozenset()) -> Wire:
    wire = Wire()
    wire.listen(Telemetry().wanted | set(wanted), continual)
    return wire


def test_nothing_leaves_and_nothing_is_handed_out_before_an_autopilot_was_heard() -> None:
    wire = wire_of("NAMED_VALUE_INT")
    assert wire.parse([MavlinkCodec(1, 26).pack(named("target", 1))]) == []
    assert wire.pack([HEARTBEAT]) == []
    assert wire.system == 0


@pytest.mark.parametrize("system", [1, 7, 255])
def test_the_system_id_is_learned(system: int) -> None:
    wire = wire_of()
    heard = wire.parse(Autopilot(system).telemetry())
    assert {m.get_type() for m in heard} >= {"HEARTBEAT", "LOCAL_POSITION_NED"}
    (datagram,) = wire.pack([HEARTBEAT])
    assert (datagram[5], datagram[6]) == (system, 191)


def test_the_first_autopilot_stays_the_one() -> None:
    wire = wire_of()
    wire.parse(Autopilot(3).telemetry())
    assert {m.get_srcSystem() for m in wire.parse(Autopilot(2).telemetry())} == {2}
    assert wire.system == 3


@pytest.mark.parametrize(
    ("component", "autopilot"),
    [(191, dialect.MAV_AUTOPILOT_INVALID), (1, dialect.MAV_AUTOPILOT_INVALID), (25, 12)],
)
def test_only_an_autopilot_is_learned_from(component: int, autopilot: int) -> None:
    wire = wire_of()
    heartbeat = dialect.MAVLink_heartbeat_message(6, autopilot, 0, 0, 4, 3)
    wire.parse([MavlinkCodec(9, component).pack(heartbeat)])
    assert wire.pack([HEARTBEAT]) == []


def test_frames_are_numbered_without_gaps() -> None:
    wire = wire_of()
    wire.parse(Autopilot().telemetry())
    numbers = [wire.pack([HEARTBEAT])[0][4] for _ in range(300)]
    assert numbers == [i % 256 for i in range(300)]


def test_only_what_is_asked_for_is_decoded_and_only_the_newest_of_what_is_continual() -> None:
    wire = wire_of(continual=frozenset({"BATTERY_STATUS"}))
    autopilot = Autopilot()
    wire.parse(autopilot.telemetry())
    packed = [autopilot.codec.pack(m) for m in (battery(5), named("x", 1), battery(6))]
    (heard,) = wire.parse(packed)
    assert heard.battery_remaining == 6
    wire.listen(frozenset({"NAMED_VALUE_INT"}), frozenset())
    packed = [autopilot.codec.pack(m) for m in (battery(5), named("x", 1), battery(6))]
    assert [m.get_type() for m in wire.parse(packed)] == ["NAMED_VALUE_INT"]
